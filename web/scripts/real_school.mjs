// A school on a real enamel-server, for measuring: the demo's people, three teeth with an attempt each (class I in a
// real molar where ../shared/data has one, class II, crown) that are compared with a reference, and a class of sixteen
// to grade, one of whom cut the mesial wall too far. Its programs are those of build/release, or of ENAMEL_BIN; the
// molar is in ../shared/data, or in ENAMEL_SHARED_DATA.
import { execFile, spawn } from "node:child_process";
import { randomUUID } from "node:crypto";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

const run = promisify(execFile);
const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const kPrograms = process.env.ENAMEL_BIN ?? here("../../build/release/bin");
const kRealMolar = join(process.env.ENAMEL_SHARED_DATA ?? here("../../../shared/data"), "crowns/fdi_46.obj");
export const kClass = 16;
export const kCohort = "Demo cohort";
const kMostMs = 300_000; // of one command
const kMostBytes = 1 << 24; // that it says
const kStartMs = 60_000;
const kDemo = (login) => ({ login, password: `enamel-demo-${login}` });

export const instructor = kDemo("instructor");
export const student = kDemo("student1");

function listening(port) {
  return new Promise((resolve) => {
    const server = createServer();
    server.once("error", () => resolve(undefined));
    server.listen(port, "127.0.0.1", () => resolve(server));
  });
}
// Two neighbours: page and station link.
async function freePorts() {
  for (;;) {
    const one = await listening(0);
    const { port } = one.address();
    const two = await listening(port + 1);
    one.close();
    two?.close();
    if (two !== undefined) return port;
  }
}

async function started(args) {
  const server = spawn(join(kPrograms, "enamel-server"), args, { stdio: ["ignore", "pipe", "inherit"] });
  let said = "";
  await new Promise((resolve, reject) => {
    const timer = setTimeout(
      () => reject(new Error(`the server is not ready after ${kStartMs} ms: ${said}`)),
      kStartMs,
    );
    server.once("exit", (code) => reject(new Error(`the server ended with ${code}: ${said}`)));
    server.stdout.on("data", (text) => {
      said += text;
      if (!/^ready/m.test(said)) return;
      clearTimeout(timer);
      resolve();
    });
  });
  return server;
}

// The server makes playbacks when it has nothing else to do.
async function playbacksMade(url, teeth) {
  const answer = await fetch(`${url}/api/v1/session`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(instructor),
  });
  if (!answer.ok) throw new Error(`the instructor cannot sign in: ${answer.status}`);
  const headers = {
    Cookie: answer.headers
      .getSetCookie()
      .map((cookie) => cookie.split(";")[0])
      .join("; "),
  };
  const end = Date.now() + kMostMs;
  for (const { name, attempt } of teeth) {
    for (;;) {
      const { status } = await fetch(`${url}/api/v1/attempts/${attempt}/timeline`, { method: "HEAD", headers });
      if (status === 200) break;
      if (Date.now() > end) throw new Error(`the playback of ${name} was not made within ${kMostMs} ms: ${status}`);
      await new Promise((resolve) => setTimeout(resolve, 500));
    }
  }
}

// `classToGrade`: whether to make the class of sixteen, which takes half of the time. Throws where anything fails.
export async function startSchool({ dist, classToGrade = true }) {
  if (!existsSync(join(kPrograms, "enamel-server")))
    throw new Error(`expected the programs in ${kPrograms}, found none: build the preset release, or set ENAMEL_BIN`);
  const folder = mkdtempSync(join(tmpdir(), "enamel-school-"));
  const [data, station] = [join(folder, "server"), join(folder, "station")];
  let server;
  const close = async () => {
    if (server !== undefined && server.exitCode === null) {
      const ended = new Promise((resolve) => {
        server.once("exit", resolve);
      });
      server.kill();
      await ended;
    }
    rmSync(folder, { recursive: true, force: true });
  };
  const program = (name, args, environment = {}) => {
    const env = { ...process.env, ...environment };
    return run(join(kPrograms, name), args, { env, timeout: kMostMs, maxBuffer: kMostBytes });
  };
  const onServer = (...args) => program("enamel-server", [...args, "--data", data]);
  const attempt = async ({ login, password }, exercise, operator, ...more) => {
    const facts = join(folder, "attempt.json");
    const args = ["run", "--data", station, "--exercise", exercise, "--quiet", "--profile", "phantom_desktop"];
    args.push("--user", login, "--operator", operator, "--lockstep", "--json", facts, ...more);
    await program("enamel-station", args, { ENAMEL_PASSWORD: password });
    return JSON.parse(readFileSync(facts, "utf8")).attempt_id;
  };
  const scored = (id) => onServer("report", "--attempt", id, "--wait", "300");
  const reference = async (exercise) => {
    const id = await attempt(instructor, exercise, "dentist", "--as-reference");
    await scored(id);
    await onServer("admin", "mark-reference", "--attempt", id, "--dentist", "Simulated dentist", "--consent");
  };
  try {
    await onServer("init");
    // The class cuts a coarse tooth, which takes no time.
    await onServer("seed-demo", "--voxel-um", "150");
    let molar = "builtin:molar-caries"; // not the demo's molar: an exercise of that name is there
    if (existsSync(kRealMolar)) {
      molar = join(folder, "molar");
      await program("enamel-station", ["import", kRealMolar, "--tooth", "46", "--unit", "mm", "--out", molar]);
    }
    const scenes = [
      { name: existsSync(kRealMolar) ? "real molar" : "molar", scene: molar, kind: "class-1" },
      { name: "class II", scene: "builtin:molar-class-2", kind: "class-2" },
      { name: "crown", scene: "builtin:premolar", kind: "crown" },
    ];
    for (const scene of scenes) {
      const { stdout } = await onServer("admin", "publish-exercise", "--scene", scene.scene, "--name", scene.kind);
      scene.exercise = /exercise "([^"]+)"/.exec(stdout)[1];
    }
    const port = await freePorts();
    const url = `http://127.0.0.1:${port}`;
    const link = `127.0.0.1:${port + 1}`;
    server = await started(["serve", "--data", data, "--http", `127.0.0.1:${port}`, "--stations", link, "--web", dist]);
    const code = (await onServer("admin", "enrol-code")).stdout.trim();
    await program("enamel-station", [
      "enrol",
      "--data",
      station,
      "--server",
      link,
      "--name",
      "Chair 1",
      "--code",
      code,
    ]);
    const teeth = [];
    for (const { name, exercise, kind } of scenes) {
      await reference(exercise);
      const id = await attempt(student, exercise, kind === "crown" ? "good" : "student-deep-mesial");
      await scored(id);
      await onServer("admin", "release", "--attempt", id);
      teeth.push({ name, attempt: id });
    }
    if (classToGrade) {
      await reference("class-1-molar-46");
      for (let i = 0; i < kClass; ++i) {
        const one = { login: `person${i}`, password: randomUUID() };
        const person = ["--login", one.login, "--role", "student", "--password-stdin"];
        const added = onServer("admin", "add-person", ...person);
        added.child.stdin.end(`${one.password}\n`);
        await added;
        await onServer("admin", "add-to-cohort", "--cohort", kCohort, "--login", one.login);
        const operator = i === kClass - 1 ? "student-deep-mesial" : "student";
        await scored(await attempt(one, "class-1-molar-46", operator, "--seed", String(i + 1)));
      }
    }
    await playbacksMade(url, teeth);
    return { url, teeth, close };
  } catch (error) {
    await close();
    throw error;
  }
}
