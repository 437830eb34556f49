// What one request costs a server of a large school, in its processor's time and, under with_postgres.sh, in that of the
// database's processes too:
//   node tests/bench/request_cost.mjs [--school DIR] [ATTEMPTS]     3000, unless told; 20000 take 22 minutes to copy
//   tests/support/with_postgres.sh node tests/bench/request_cost.mjs
// The attempts are copied from what the students of the school (tests/e2e/school) did, by large_class.
import { execFileSync } from "node:child_process";
import { cpSync, mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { setTimeout as sleep } from "node:timers/promises";
import { kSchool } from "../e2e/school/open.mjs";
import { signedInAt } from "../e2e/school/person.mjs";
import { ended, program, startedServer } from "../e2e/school/programs.mjs";

const words = process.argv.slice(2);
const at = words.indexOf("--school");
const folder = at < 0 ? kSchool : words.splice(at, 2)[1];
const attempts = words[0] ?? "3000";
const postgres = process.env.ENAMEL_POSTGRES;
const kRequests = 200;
const kMaxMs = 3_600_000;

const ticksPerSecond = Number(execFileSync("getconf", ["CLK_TCK"], { encoding: "utf8" }));
function statOf(pid) {
  try {
    const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ").at(-1).split(" ");
    return { parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12]) };
  } catch {
    return { parent: 0, ticks: 0 }; // it has ended
  }
}
const postmaster = () => {
  const place = execFileSync("psql", ["-XAtc", "SHOW data_directory", postgres], { encoding: "utf8" }).trim();
  return Number(readFileSync(join(place, "postmaster.pid"), "utf8").split("\n")[0]);
};
const database = postgres && postmaster();
function msOf(server) {
  const own = statOf(server).ticks;
  const theirs = !database
    ? 0
    : readdirSync("/proc")
        .filter((name) => /^\d+$/.test(name))
        .map(statOf)
        .filter(({ parent }) => parent === database)
        .reduce((sum, { ticks }) => sum + ticks, 0);
  return ((own + theirs) * 1000) / ticksPerSecond;
}

const work = mkdtempSync(join(tmpdir(), "enamel-cost-"));
let data = join(work, "data");
let server;
try {
  cpSync(join(folder, "data"), data, { recursive: true });
  const { people, cohorts, assignments, class: students } = JSON.parse(readFileSync(join(folder, "school.json"), "utf8"));
  await program("large_class", [data, assignments.graded, attempts], { mostMs: kMaxMs });
  if (postgres) {
    const to = join(work, "moved");
    await program("enamel-server", ["move", "--data", data, "--to", to, "--database", postgres], { mostMs: kMaxMs });
    data = to;
  }
  // Without jobs: playbacks and pictures of what was copied are no request's.
  server = await startedServer(data, join(folder, "page"), "--job-threads", "0");
  const student = await signedInAt(server.url, students[0]);
  const instructor = await signedInAt(server.url, people.instructor);
  const admin = await signedInAt(server.url, people.admin);
  for (const [name, who, path] of [
    ["a student's list", student, "/attempts"],
    ["an instructor's list", instructor, "/attempts"],
    ["the same, lowest score first", instructor, "/attempts?order=lowest_score"],
    ["the same by name", instructor, "/attempts?order=name"],
    ["people by a part of a name", admin, "/people?text=mar"],
    ["cohorts", admin, "/cohorts"],
    ["insight of an assignment", instructor, `/assignments/${assignments.graded}/insight`],
    ["a cohort", instructor, `/cohorts/${cohorts.first}`],
  ]) {
    await who.get(path);
    const before = msOf(server.child.pid);
    let bytes = 0;
    for (let i = 0; i < kRequests; ++i) bytes = JSON.stringify(await who.get(path)).length;
    const each = (msOf(server.child.pid) - before) / kRequests;
    console.log(`${name}: ${each.toFixed(2)} ms of CPU, ${(bytes / 1000).toFixed(1)} kB`);
  }
} finally {
  await ended(server?.child, "SIGKILL");
  rmSync(work, { recursive: true, force: true });
}
