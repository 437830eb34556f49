// A school on a real enamel-server, for measuring: the demo's people, three teeth with an attempt each (class I in a
// real molar where ../shared/data has one, class II, crown) that are compared with a reference, and a class of sixteen
// to grade, one of whom cut the mesial wall too far. Its programs are those of build/release, or of ENAMEL_BIN; the
// molar is in ../shared/data, or in ENAMEL_SHARED_DATA.
import { randomUUID } from "node:crypto";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { ended, kPrograms, program, startedServer } from "../../tests/e2e/school/programs.mjs";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const kRealMolar = join(process.env.ENAMEL_SHARED_DATA ?? here("../../../shared/data"), "crowns/fdi_46.obj");
export const kClass = 16;
export const kCohort = "Demo cohort";
const kMaxMs = 300_000; // of making a playback
const kDemo = (login) => ({ login, password: `enamel-demo-${login}` });

export const instructor = kDemo("instructor");
export const student = kDemo("student1");

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
  const end = Date.now() + kMaxMs;
  for (const { name, attempt } of teeth) {
    for (;;) {
      const { status } = await fetch(`${url}/api/v1/attempts/${attempt}/timeline`, { method: "HEAD", headers });
      if (status === 200) break;
      if (Date.now() > end) throw new Error(`the playback of ${name} was not made within ${kMaxMs} ms: ${status}`);
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
    await ended(server?.child);
    rmSync(folder, { recursive: true, force: true });
  };
  const onServer = (args, options) => program("enamel-server", [...args, "--data", data], options);
  const attempt = async ({ login, password }, exercise, operator, ...more) => {
    const facts = join(folder, "attempt.json");
    const args = ["run", "--data", station, "--exercise", exercise, "--quiet", "--profile", "phantom_desktop"];
    args.push("--user", login, "--operator", operator, "--lockstep", "--json", facts, ...more);
    await program("enamel-station", args, { environment: { ENAMEL_PASSWORD: password } });
    return JSON.parse(readFileSync(facts, "utf8")).attempt_id;
  };
  const scored = (id) => onServer(["report", "--attempt", id, "--wait", "300"]);
  const reference = async (exercise) => {
    const id = await attempt(instructor, exercise, "dentist", "--as-reference");
    await scored(id);
    await onServer(["admin", "mark-reference", "--attempt", id, "--dentist", "Simulated dentist", "--consent"]);
  };
  try {
    await onServer(["init"]);
    // The class cuts a coarse tooth, which takes no time.
    await onServer(["seed-demo", "--voxel-um", "150"]);
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
      const said = await onServer(["admin", "publish-exercise", "--scene", scene.scene, "--name", scene.kind]);
      scene.exercise = /exercise "([^"]+)"/.exec(said)[1];
    }
    server = await startedServer(data, dist);
    const { url, link } = server;
    const code = (await onServer(["admin", "enrol-code"])).trim();
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
      await onServer(["admin", "release", "--attempt", id]);
      teeth.push({ name, attempt: id });
    }
    if (classToGrade) {
      await reference("class-1-molar-46");
      for (let i = 0; i < kClass; ++i) {
        const one = { login: `person${i}`, password: randomUUID() };
        const person = ["--login", one.login, "--role", "student", "--password-stdin"];
        await onServer(["admin", "add-person", ...person], { input: `${one.password}\n` });
        await onServer(["admin", "add-to-cohort", "--cohort", kCohort, "--login", one.login]);
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
