// Browser tests of the page.
//   node tests/e2e/run.mjs [--dist DIR] [--school DIR] [--pictures DIR] [--only TEXT] [--from N] [--lanes N]
// --school: what school/make.mjs made; default: build/release/school. Flows run on a real server with a copy of it, behind
// proxy.mjs; after a flow that changed something the next one gets a new copy.
// --lanes: how many flows at a time, each on a browser and a school of its own; default: 2.
// --pictures: keeps pictures of each flow; without it only failed flows leave one, in
// web/build/pictures. With ENAMEL_FULL every screen is shown in each language, theme and width.
// With BASE_URL (and STUDENT_LOGIN, STUDENT_PASSWORD,
// INSTRUCTOR_LOGIN, INSTRUCTOR_PASSWORD, ADMIN_LOGIN, ADMIN_PASSWORD; FOREIGN_ATTEMPT, the id of an
// attempt that is not the student's): those flows that are marked `anywhere`, against that server. Ends with 0 when all
// pass, 1 when one fails, 77 when there is no Chromium.
import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { begin, chromiumIsThere, launch, leave, newPage } from "./browser.mjs";
import { flows } from "./flows.mjs";
import { kSchool, openSchool } from "./school/open.mjs";
import { signedInAt } from "./school/person.mjs";

const kSkipped = 77;
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
async function runFlow(flow, { pages, newPage, ...world }, failedPicture) {
  const opened = [];
  await world.opened?.fresh();
  const open = async (options) => {
    pages[opened.length] ??= await newPage();
    const page = pages[opened.length];
    opened.push({ page, errors: await begin(page, options) });
    return page;
  };
  try {
    await flow.run({ open, ...world });
    assert.deepEqual(
      opened.flatMap(({ errors }) => errors),
      [],
      "errors in the browser's console",
    );
  } catch (error) {
    await Promise.all(
      opened.map(({ page }, i) => page.screenshot({ path: failedPicture(i), fullPage: true }).catch(() => {})),
    );
    throw error;
  } finally {
    await Promise.all(opened.map(({ page }) => leave(page)));
  }
}

// Lays out what waits until somebody comes there: it would be an empty tail of a picture.
function whole() {
  for (const element of document.querySelectorAll("main *"))
    if (getComputedStyle(element).contentVisibility === "auto") element.style.contentVisibility = "visible";
}

// `waiting`: numbers and flows, of which every lane takes the next.
async function runLane(waiting, world, pictures) {
  let failed = 0;
  for (const [index, flow] of waiting) {
    const begun = performance.now();
    const pathOf = (folder, name) => join(folder, `${String(index + 1).padStart(2, "0")}_${name}.png`);
    const picture = async (shown, name, options = {}) => {
      if (pictures === undefined) return;
      await shown.evaluate(whole);
      await shown.screenshot({ path: pathOf(pictures, name), ...options });
    };
    try {
      await runFlow(flow, { ...world, newPage: () => newPage(world.browser, world.baseUrl), picture }, (i) =>
        pathOf(kFailed, `failed_${i}`),
      );
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
const folder = option("--school") ?? kSchool;
const pictures = option("--pictures");
mkdirSync(kFailed, { recursive: true });
if (pictures !== undefined) mkdirSync(pictures, { recursive: true });
const only = option("--only") ?? "";
const from = Number(option("--from") ?? 1);
// Those marked `seldom` run with ENAMEL_FULL=1, by their name, and against a server of somebody else's.
const all = process.env.ENAMEL_FULL === "1" || only !== "" || real !== undefined;
const selected = flows
  .slice(from - 1)
  .filter((flow) => (all || !flow.seldom) && (real === undefined || flow.anywhere) && flow.name.includes(only));

function anywhere() {
  return {
    baseUrl: real,
    logins: loginsFromEnvironment(),
    foreignAttempt: process.env.FOREIGN_ATTEMPT,
    close: () => {},
  };
}

function momentOf(ms) {
  const tenths = Math.floor(ms / 100);
  const seconds = ((tenths / 10) % 60).toFixed(1).padStart(4, "0");
  return { frames: Math.ceil(ms / 100), text: `${Math.floor(tenths / 600)}:${seconds}` };
}

async function onSchool() {
  const opened = await openSchool({ folder, dist });
  const { school } = opened;
  return {
    baseUrl: opened.url,
    logins: school.people,
    foreignAttempt: school.attempts.class3,
    opened,
    school,
    attempt: (name, rest = "") => `/attempts/${school.attempts[name]}${rest}`,
    assignment: (name) => `/assignments/${school.assignments[name]}`,
    grading: (name) => `/grading?assignment=${school.assignments[name]}`,
    exercise: (name) => `/exercises/${school.exercises[name]}`,
    cohort: (name) => `/cohorts/${school.cohorts[name]}`,
    // Of the attempt "shown", as the playback counts it.
    end: momentOf(school.shown_ms),
    as: (login) => signedInAt(opened.url, school.people[login]),
    close: opened.close,
  };
}

async function lane(waiting) {
  const browser = await launch();
  const world = { ...(await (real === undefined ? onSchool() : anywhere())), browser, pages: [] };
  try {
    return await runLane(waiting, world, pictures);
  } finally {
    await browser.close();
    await world.close();
  }
}

const lanes = real === undefined ? Math.min(Number(option("--lanes") ?? 2), selected.length) : 1;
const waiting = selected.entries();
const failed = (await Promise.all(Array.from({ length: lanes }, () => lane(waiting)))).reduce((sum, n) => sum + n, 0);
console.log(
  `${selected.length - failed} of ${selected.length} flows passed${failed > 0 ? `; pictures in ${kFailed}` : ""}`,
);
process.exit(failed === 0 && selected.length > 0 ? 0 : 1);
