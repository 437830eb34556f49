// A small school on a real server: the demo's people, a coarse tooth, three recorded attempts, and one more to watch.
import { execFile, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { createServer } from "node:net";
import { Person, until } from "./client.mjs";

const run = promisify(execFile);
const kBin = process.env.ENAMEL_BIN ?? fileURLToPath(new URL("../../build/release/bin", import.meta.url));
const program = (name) => join(kBin, name);
const kExercise = "class-1-molar-46";

// A process that is told to stop with the test, and what it has said until then.
class Running {
  said = "";
  constructor(name, args, env = {}) {
    this.process = spawn(program(name), args, { env: { ...process.env, ...env }, stdio: ["ignore", "pipe", "pipe"] });
    this.ended = new Promise((resolve) => this.process.once("exit", resolve));
    for (const stream of [this.process.stdout, this.process.stderr])
      stream.on("data", (text) => {
        this.said += text;
      });
  }
  async saying(pattern) {
    const found = await until(
      `${this.process.spawnfile} says ${pattern}`,
      async () => pattern.exec(this.said) ?? this.process.exitCode,
      (answer) => answer !== null,
    );
    if (typeof found === "number") throw new Error(`${this.process.spawnfile} ended with ${found}: ${this.said}`);
    return found;
  }
  async stop() {
    this.process.kill("SIGTERM");
    await this.ended;
  }
}

async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

async function startServer(folder, name, shown, more = []) {
  const stations = `127.0.0.1:${await freePort()}`;
  const server = new Running("enamel-server", [
    ...["serve", "--data", join(folder, name), "--http", "127.0.0.1:0", "--stations", stations],
    ...["--web", shown, "--min-free-mib", "0", ...more],
  ]);
  const [, url] = await server.saying(/^ready: page (\S+),/m);
  return { server, url, stations };
}

// A server that has no admin yet, and its token.
async function startNewServer(folder, shown) {
  await run(program("enamel-server"), ["init", "--data", join(folder, "new")]);
  const { server, url } = await startServer(folder, "new", shown);
  const [, token] = await server.saying(/\/first#(\S+) /);
  return { server, newcomer: new Person(url, "newcomer"), token };
}

const kDemo = { admin: "admin", ben: "instructor", sam: "student1", sue: "student2" };

// `page`: the folder of the built page; without it the server shows one line.
export async function startSchool({ page } = {}) {
  const folder = mkdtempSync(join(tmpdir(), "enamel-contract-"));
  const running = [];
  const close = async () => {
    await Promise.all(running.map((one) => one.stop()));
    rmSync(folder, { recursive: true, force: true });
  };
  try {
    for (const name of ["page", "backups"]) mkdirSync(join(folder, name));
    writeFileSync(join(folder, "page", "index.html"), "<!doctype html><title>Enamel</title>\n");
    const shown = page ?? join(folder, "page");
    const data = ["--data", join(folder, "school")];
    const seed = join(folder, "seed.json");
    const fresh = startNewServer(folder, shown);
    await run(program("enamel-server"), ["seed-demo", ...data, "--voxel-um", "150", "--json", seed]);
    const { exercise_id: exercise } = JSON.parse(readFileSync(seed, "utf8"));
    const { server, url, stations } = await startServer(folder, "school", shown, [
      "--backups",
      join(folder, "backups"),
    ]);
    running.push(server);
    const { server: other, newcomer, token } = await fresh;
    running.push(other);
    const w = { url, exercise, newcomer, token };
    w.nobody = new Person(url, "nobody");
    w.guest = new Person(url, "guest");
    for (const [name, login] of Object.entries(kDemo))
      w[name] = await Person.signedIn(url, name, login, `enamel-demo-${login}`);

    const station = ["--data", join(folder, "station")];
    const { code } = (await w.admin.need("POST", "/api/v1/enrolment-codes", { body: {} })).json;
    await run(program("enamel-station"), [
      "enrol",
      ...station,
      "--server",
      stations,
      "--name",
      "Chair 1",
      "--code",
      code,
    ]);
    const chair = (person, operator, more) => {
      const env = { ENAMEL_PASSWORD: person.password };
      const args = ["run", ...station, "--exercise", kExercise, "--profile", "phantom_desktop", "--quiet"];
      return new Running("enamel-station", [...args, "--user", person.login, "--operator", operator, ...more], env);
    };
    const record = async (person, operator, ...more) => {
      const attempt = chair(person, operator, ["--lockstep", ...more]);
      const rc = await attempt.ended;
      if (rc !== 0) throw new Error(`${person.name}'s attempt ended with ${rc}: ${attempt.said}`);
      return /^attempt (\S+)$/m.exec(attempt.said)[1];
    };
    const scored = (id) =>
      until(
        `attempt ${id} is scored`,
        () => w.admin.ask("GET", `/api/v1/attempts/${id}`),
        ({ json }) => json.state === "scored",
      );
    const reference = await record(w.ben, "dentist", "--as-reference");
    await scored(reference);
    const consent = { dentist: "Dr. Vega", consent: true };
    await w.ben.need("POST", `/api/v1/attempts/${reference}/reference`, { body: consent });
    w.scored = await record(w.sam, "student-deep-mesial");
    w.sues = await record(w.sue, "idle"); // a critical error
    await scored(w.scored);
    await scored(w.sues);
    w.demo = (await w.admin.need("GET", "/api/v1/cohorts")).json.cohorts[0].id;
    w.assignment = (await w.ben.need("GET", "/api/v1/assignments")).json.assignments[0].id;
    w.station = (await w.ben.need("GET", "/api/v1/stations")).json.stations[0].id;
    // What only the demo's cohort knows of.
    w.ofDemo = () => ({
      ...{ cohort: w.demo, assignment: w.assignment, attempt: w.scored, "other attempt": w.sues },
      ...{ recording: w.recording, marking: w.marking, batch: w.batch, exercise: w.mine },
    });
    // Runs at the clock's pace until `leave`.
    w.work = async () => {
      const attempt = chair(w.sam, "student", []);
      running.push(attempt);
      const { json } = await until(
        "an attempt is being made",
        () => w.ben.ask("GET", "/api/v1/attempts?state=recording"),
        ({ json: list }) => list.attempts.some(({ ticks }) => ticks > 0),
      );
      w.recording = json.attempts[0].id;
      return () => attempt.stop();
    };
    return { w, close };
  } catch (error) {
    await close();
    throw error;
  }
}
