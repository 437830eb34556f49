// What a large class costs who grades it:
//   node scripts/large_class.mjs [--dist DIR] [--school DIR] [STUDENTS …]   600 and 5000, unless told
// The class is copied from what the students of the school (tests/e2e/school) did, by build/release/bin/large_class, and
// `enamel-server verify` has to agree with it. Prints for the grading of its assignment and for its cohort's page:
// seconds until the table is complete, requests, their bytes, the page's elements and the seconds in which it did not
// react (long tasks); and the median of five reads of the grading by the interface alone.
import { cpSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { loadavg, tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { launch, newPage } from "../../tests/e2e/browser.mjs";
import { kSchool } from "../../tests/e2e/school/open.mjs";
import { signedInAt } from "../../tests/e2e/school/person.mjs";
import { ended, program, startedServer } from "../../tests/e2e/school/programs.mjs";

const words = process.argv.slice(2);
function option(name, usual) {
  const at = words.indexOf(name);
  return at < 0 ? usual : words.splice(at, 2)[1];
}
const dist = option("--dist", fileURLToPath(new URL("../dist", import.meta.url)));
const folder = option("--school", kSchool);
const sizes = words.length > 0 ? words : ["600", "5000"];

const kMaxMs = 3_600_000; // of making or verifying a class on a slow disk
const work = mkdtempSync(join(tmpdir(), "enamel-class-"));
const data = join(work, "data");
cpSync(join(folder, "data"), data, { recursive: true });
const { people, assignments } = JSON.parse(readFileSync(join(folder, "school.json"), "utf8"));
const instructor = people.instructor;
let server;

async function measured(browser, name, path, table) {
  const page = await newPage(browser, server.url);
  await page.addInitScript(() => {
    window.longTasksMs = 0;
    new PerformanceObserver((list) => {
      for (const { duration } of list.getEntries()) window.longTasksMs += duration;
    }).observe({ entryTypes: ["longtask"] });
  });
  await page.goto("/");
  await page.getByLabel("Login").fill(instructor.login);
  await page.getByLabel("Password").fill(instructor.password);
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.locator("main table, main .empty").first().waitFor();
  await page.waitForLoadState("networkidle");
  const asked = [];
  page.on("requestfinished", async (request) => {
    if (!new URL(request.url()).pathname.startsWith("/api/")) return;
    asked.push((await request.sizes()).responseBodySize);
  });
  const begun = performance.now();
  await page.goto(path);
  await page.locator(`${table}[aria-rowcount] tr[aria-rowindex]`).first().waitFor();
  const seconds = (performance.now() - begun) / 1000;
  await page.waitForLoadState("networkidle");
  const { rows, nodes, longMs } = await page.evaluate((selector) => {
    const all = document.querySelectorAll("*").length;
    return {
      rows: Number(document.querySelector(selector).getAttribute("aria-rowcount")) - 1,
      nodes: all,
      longMs: window.longTasksMs,
    };
  }, table);
  console.log(
    `${name}: ${rows} rows, ${seconds.toFixed(2)} s, ${asked.length} requests, ` +
      `${(asked.reduce((sum, size) => sum + size, 0) / 1e6).toFixed(2)} MB, ${nodes} nodes, ${(longMs / 1000).toFixed(2)} s of long tasks`,
  );
  await page.context().close();
}

async function readAlone(assignment) {
  const teacher = await signedInAt(server.url, instructor);
  const took = [];
  for (let i = 0; i < 5; ++i) {
    const begun = performance.now();
    await teacher.get(`/assignments/${assignment}/grading`);
    took.push(performance.now() - begun);
  }
  console.log(`grading by the interface alone: ${took.sort((a, b) => a - b)[2].toFixed(0)} ms`);
}

const browser = await launch();
try {
  for (const size of sizes) {
    const said = await program("large_class", [data, assignments.graded, size], { mostMs: kMaxMs });
    const [, assignment, cohort, took] = /assignment (\S+)\ncohort (\S+)\n(.*)\n/.exec(said);
    const agrees = (await program("enamel-server", ["verify", "--data", data], { mostMs: kMaxMs }))
      .trim()
      .split("\n")
      .at(-1);
    console.log(`${took}; verify: ${agrees}; load average ${loadavg()[0].toFixed(1)}`);
    server = await startedServer(data, dist);
    await measured(browser, "grading", `/grading?assignment=${assignment}`, "table.grading");
    await measured(browser, "cohort", `/cohorts/${cohort}`, "table.stacking");
    await readAlone(assignment);
    await ended(server.child);
  }
} finally {
  await browser.close();
  await ended(server?.child, "SIGKILL");
  rmSync(work, { recursive: true, force: true });
}
