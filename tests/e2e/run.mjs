// Browser tests of the page.
//   node tests/e2e/run.mjs [--dist DIR] [--pictures DIR] [--only TEXT]
// Without BASE_URL: against the mock server. With BASE_URL (and STUDENT_LOGIN, STUDENT_PASSWORD,
// INSTRUCTOR_LOGIN, INSTRUCTOR_PASSWORD, ADMIN_LOGIN, ADMIN_PASSWORD; FOREIGN_ATTEMPT,
// the id of an attempt that is not the student's): against that server.
// Ends with 0 when all pass, 1 when one fails, 77 when there is no Chromium.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromiumIsThere, launch } from "./browser.mjs";
import { flows, runFlow } from "./flows.mjs";
import { startMockServer } from "./mock_server.mjs";
import { people } from "./mock_world.mjs";

const kSkipped = 77;
const kMockForeignAttempt = "00000000-0000-7000-8000-000000000104";
const kRoles = ["student", "instructor", "admin"];

function option(name) {
  const at = process.argv.indexOf(name);
  return at < 0 ? undefined : process.argv[at + 1];
}

function loginsFromEnvironment() {
  return Object.fromEntries(kRoles.map((role) => {
    const name = role.toUpperCase();
    const [login, password] = [process.env[`${name}_LOGIN`], process.env[`${name}_PASSWORD`]];
    if (!login || !password) throw new Error(`BASE_URL is set, so ${name}_LOGIN and ${name}_PASSWORD are expected; found none`);
    return [role, { login, password }];
  }));
}

async function runAll(browser, selected, { mock, ...server }, pictures) {
  let failed = 0;
  for (const [index, flow] of selected.entries()) {
    mock?.reset();
    const begun = performance.now();
    const picture = (name) => join(pictures, `${String(index + 1).padStart(2, "0")}_${name}.png`);
    try {
      await runFlow(flow, browser, { ...server, picture, mock: mock?.world, broken: mock?.broken });
      const broken = mock?.broken.splice(0) ?? [];
      if (broken.length > 0) throw new Error(`the mock server broke its contract, schemas/api/openapi.yaml:\n${broken.join("\n")}`);
      console.log(`ok ${index + 1} - ${flow.name} (${((performance.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failed;
      console.log(`not ok ${index + 1} - ${flow.name}\n${[error.stack, ...mock?.broken.splice(0) ?? []].join("\n")}`);
    }
  }
  return failed;
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium (install Debian's chromium, or name another with CHROMIUM)");
  process.exit(kSkipped);
}

const real = process.env.BASE_URL;
const dist = option("--dist") ?? fileURLToPath(new URL("../../web/dist", import.meta.url));
const pictures = option("--pictures") ?? fileURLToPath(new URL("../../web/build/pictures", import.meta.url));
mkdirSync(pictures, { recursive: true });
const mock = real === undefined ? await startMockServer({ dist }) : undefined;
const server = mock === undefined ? { baseUrl: real, logins: loginsFromEnvironment(), foreignAttempt: process.env.FOREIGN_ATTEMPT ?? kMockForeignAttempt }
  : { baseUrl: mock.url, logins: Object.fromEntries(kRoles.map((role) => [role, people.find((person) => person.role === role)])), foreignAttempt: kMockForeignAttempt, mock };
const only = option("--only") ?? "";
const selected = flows.filter((flow) => (real === undefined || flow.anywhere) && flow.name.includes(only));

const browser = await launch();
let failed = 1;
try {
  failed = await runAll(browser, selected, server, pictures);
} finally {
  await browser.close();
  await mock?.close();
}
console.log(`${selected.length - failed} of ${selected.length} flows passed; pictures in ${pictures}`);
process.exit(failed === 0 && selected.length > 0 ? 0 : 1);
