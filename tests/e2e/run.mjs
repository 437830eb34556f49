// Browser tests of the page: one server and one browser for all flows, each with a world of its
// own.
//   node tests/e2e/run.mjs [--dist DIR] [--pictures DIR] [--only TEXT]
// --pictures: keeps pictures of each flow; without it only failed flows leave one, in
// web/build/pictures. With ENAMEL_FULL every screen is shown in each language, theme and width.
// Without BASE_URL: against the mock server. With BASE_URL (and STUDENT_LOGIN, STUDENT_PASSWORD,
// INSTRUCTOR_LOGIN, INSTRUCTOR_PASSWORD, ADMIN_LOGIN, ADMIN_PASSWORD; FOREIGN_ATTEMPT, the id of an
// attempt that is not the student's): against that server. Ends with 0 when all pass, 1 when one
// fails, 77 when there is no Chromium.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { begin, chromiumIsThere, launch, leave, newPage } from "./browser.mjs";
import { flows } from "./flows.mjs";
import { startMockServer } from "./mock_server.mjs";
import { people } from "./mock_world.mjs";

const kSkipped = 77;
const kMockForeignAttempt = "00000000-0000-7000-8000-000000000104";
const kFailed = fileURLToPath(new URL("../../web/build/pictures", import.meta.url));
const kRoles = ["student", "instructor", "admin"];

function option(name) {
  const at = process.argv.indexOf(name);
  return at < 0 ? undefined : process.argv[at + 1];
}

function loginsFromEnvironment() {
  return Object.fromEntries(
    kRoles.map((role) => {
      const name = role.toUpperCase();
      const [login, password] = [process.env[`${name}_LOGIN`], process.env[`${name}_PASSWORD`]];
      if (!login || !password)
        throw new Error(`BASE_URL is set, so ${name}_LOGIN and ${name}_PASSWORD are expected; found none`);
      return [role, { login, password }];
    }),
  );
}

// Runs one flow: `open` returns a page for each of its persons. The next flow uses the same pages,
// emptied: that saves starting processes and loading scripts. Fails if the page logged an error or
// broke its policy.
async function runFlow(flow, { pages, newPage, mock, ...world }, failedPicture) {
  const opened = [];
  mock?.reset();
  const open = async (options) => {
    pages[opened.length] ??= await newPage();
    const page = pages[opened.length];
    opened.push({ page, errors: await begin(page, options) });
    return page;
  };
  try {
    await flow.run({ open, mock: mock?.world, broken: mock?.broken, ...world });
    assert.deepEqual(
      opened.flatMap(({ errors }) => errors),
      [],
      "errors in the browser's console",
    );
    assert.deepEqual(mock?.broken ?? [], [], "answers of the mock server that break schemas/api/openapi.yaml");
  } catch (error) {
    await Promise.all(
      opened.map(({ page }, i) => page.screenshot({ path: failedPicture(i), fullPage: true }).catch(() => {})),
    );
    throw error;
  } finally {
    mock?.broken.splice(0);
    await Promise.all(opened.map(({ page }) => leave(page)));
  }
}

async function runAll(selected, world, pictures) {
  let failed = 0;
  for (const [index, flow] of selected.entries()) {
    const begun = performance.now();
    const pathOf = (folder, name) => join(folder, `${String(index + 1).padStart(2, "0")}_${name}.png`);
    const picture = async (shown, name, options = {}) => {
      if (pictures !== undefined) await shown.screenshot({ path: pathOf(pictures, name), ...options });
    };
    try {
      await runFlow(flow, { ...world, picture }, (i) => pathOf(kFailed, `failed_${i}`));
      console.log(`ok ${index + 1} - ${flow.name} (${((performance.now() - begun) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failed;
      console.log(`not ok ${index + 1} - ${flow.name}\n${error.stack}`);
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
const pictures = option("--pictures");
mkdirSync(kFailed, { recursive: true });
if (pictures !== undefined) mkdirSync(pictures, { recursive: true });
const mock = real === undefined ? await startMockServer({ dist }) : undefined;
const server =
  mock === undefined
    ? {
        baseUrl: real,
        logins: loginsFromEnvironment(),
        foreignAttempt: process.env.FOREIGN_ATTEMPT ?? kMockForeignAttempt,
      }
    : {
        baseUrl: mock.url,
        logins: Object.fromEntries(kRoles.map((role) => [role, people.find((person) => person.role === role)])),
        foreignAttempt: kMockForeignAttempt,
        mock,
      };
const only = option("--only") ?? "";
const selected = flows.filter((flow) => (real === undefined || flow.anywhere) && flow.name.includes(only));

const browser = await launch();
let failed = 1;
try {
  failed = await runAll(selected, { ...server, pages: [], newPage: () => newPage(browser, server.baseUrl) }, pictures);
} finally {
  await browser.close();
  await mock?.close();
}
console.log(
  `${selected.length - failed} of ${selected.length} flows passed${failed > 0 ? `; pictures in ${kFailed}` : ""}`,
);
process.exit(failed === 0 && selected.length > 0 ? 0 : 1);
