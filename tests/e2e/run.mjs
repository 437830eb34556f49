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
import { inventedRoutes } from "./contract.mjs";
import { flows, runFlow } from "./flows.mjs";
import { people } from "./mock_data.mjs";
import { mockRoutes, startMockServer } from "./mock_server.mjs";

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

const mockLogins = () => Object.fromEntries(kRoles.map((role) => [role, people.find((person) => person.role === role)]));

async function runAll(browser, selected, start, pictures) {
  let failed = 0;
  for (const [index, flow] of selected.entries()) {
    const server = await start();
    const begun = performance.now();
    const picture = (name) => join(pictures, `${String(index + 1).padStart(2, "0")}_${name}.png`);
    try {
      await runFlow(flow, browser, { ...server, picture });
      console.log(`ok ${index + 1} - ${flow.name} (${((performance.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failed;
      console.log(`not ok ${index + 1} - ${flow.name}\n${error.stack}`);
    } finally {
      await server.close();
    }
  }
  return failed;
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium (install Debian's chromium, or name another with CHROMIUM)");
  process.exit(kSkipped);
}

const real = process.env.BASE_URL;
const invented = inventedRoutes(mockRoutes);
if (real === undefined && invented.length > 0) {
  console.log(`not ok - the mock server answers only what schemas/api/openapi.yaml has; it also has ${invented.join(", ")}`);
  process.exit(1);
}
const dist = option("--dist") ?? fileURLToPath(new URL("../../web/dist", import.meta.url));
const pictures = option("--pictures") ?? fileURLToPath(new URL("../../web/build/pictures", import.meta.url));
mkdirSync(pictures, { recursive: true });
const start = real === undefined
  ? async () => {
      const { url, close, world } = await startMockServer({ dist });
      return { baseUrl: url, logins: mockLogins(), foreignAttempt: kMockForeignAttempt, mock: world, close };
    }
  : async () => ({ baseUrl: real, logins: loginsFromEnvironment(), foreignAttempt: process.env.FOREIGN_ATTEMPT ?? kMockForeignAttempt, close: async () => {} });
const only = option("--only") ?? "";
const selected = flows.filter((flow) => (real === undefined || flow.anywhere) && flow.name.includes(only));

const browser = await launch();
let failed = 1;
try {
  failed = await runAll(browser, selected, start, pictures);
} finally {
  await browser.close();
}
console.log(`${selected.length - failed} of ${selected.length} flows passed; pictures in ${pictures}`);
process.exit(failed === 0 && selected.length > 0 ? 0 : 1);
