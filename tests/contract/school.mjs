// A small school on a real server: the demo's people, a coarse tooth, three recorded attempts, and one more to watch.
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { ended, program, spawned, startedServer } from "../e2e/school/programs.mjs";
import { Person, until } from "./client.mjs";

const kExercise = "class-1-molar-46";
const kOnAnyDisk = ["--min-free-mib", "0"];

// A server that has no admin yet, and its token.
async function startNewServer(folder, shown) {
  await program("enamel-server", ["init", "--data", join(folder, "new")]);
  const { url, child, said } = await startedServer(join(folder, "new"), shown, ...kOnAnyDisk);
  const [, token] = await until("the first admin's link", async () => /\/first#(\S+) /.exec(said()));
  return { child, newcomer: new Person(url, "newcomer"), token };
}

const kDemo = { admin: "admin", ben: "instructor", sam: "student1", sue: "student2" };

export async function startSchool() {
  const folder = mkdtempSync(join(tmpdir(), "enamel-contract-"));
  const running = [];
  const close = async () => {
    await Promise.all(running.map((child) => ended(child)));
    rmSync(folder, { recursive: true, force: true });
  };
  try {
    for (const name of ["page", "backups"]) mkdirSync(join(folder, name));
    writeFileSync(join(folder, "page", "index.html"), "<!doctype html><title>Enamel</title>\n");
    const shown = join(folder, "page");
    const data = ["--data", join(folder, "school")];
    const seed = join(folder, "seed.json");
    const fresh = startNewServer(folder, shown);
    await program("enamel-server", ["seed-demo", ...data, "--voxel-um", "150", "--json", seed]);
    await program("enamel-server", ["retention", ...data, "--set", "recordings", "--days", "730"]);
    const { exercise_id: exercise } = JSON.parse(readFileSync(seed, "utf8"));
    const backups = join(folder, "backups");
    const { url, link, child } = await startedServer(
      join(folder, "school"),
      shown,
      ...kOnAnyDisk,
      "--backups",
      backups,
    );
    running.push(child);
    const { child: other, newcomer, token } = await fresh;
    running.push(other);
    const w = { url, exercise, newcomer, token, backups };
    w.nobody = new Person(url, "nobody");
    w.guest = new Person(url, "guest");
    for (const [name, login] of Object.entries(kDemo))
      w[name] = await Person.signedIn(url, name, login, `enamel-demo-${login}`);

    const station = ["--data", join(folder, "station")];
    const { code } = (await w.admin.need("POST", "/api/v1/enrolment-codes", { body: {} })).json;
    await program("enamel-station", ["enrol", ...station, "--server", link, "--name", "Chair 1", "--code", code]);
    const chair = (person, operator, more) => {
      const args = ["run", ...station, "--exercise", kExercise, "--profile", "phantom_desktop", "--quiet"];
      const environment = { ENAMEL_PASSWORD: person.password };
      return [[...args, "--user", person.login, "--operator", operator, ...more], environment];
    };
    const record = async (person, operator, ...more) => {
      const [args, environment] = chair(person, operator, ["--lockstep", ...more]);
      return /^attempt (\S+)$/m.exec(await program("enamel-station", args, { environment }))[1];
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
      const attempt = spawned("enamel-station", ...chair(w.sam, "student", []));
      running.push(attempt);
      const { json } = await until(
        "an attempt is being made",
        () => w.ben.ask("GET", "/api/v1/attempts?state=recording"),
        ({ json: list }) => list.attempts.some(({ ticks }) => ticks > 0),
      );
      w.recording = json.attempts[0].id;
      return () => ended(attempt);
    };
    return { w, close };
  } catch (error) {
    await close();
    throw error;
  }
}
