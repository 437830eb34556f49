// What the page costs who grades with it.
//   node scripts/budget.mjs [--dist DIR] [--school DIR]   bytes of scripts and style, and clicks, on the school
//   node scripts/budget.mjs --json FILE [--dist DIR]   real teeth on a real server, in a slowed Chromium (some minutes)
// The first ends with 1 where more bytes or clicks are needed than allowed. The second writes the figures and never
// fails by them: they depend on the machine. Of three teeth it takes the worst. Ends with 77 where there is no Chromium.
import { writeFileSync } from "node:fs";
import { loadavg } from "node:os";
import { fileURLToPath } from "node:url";
import { begin, chromiumIsThere, launch, newPage } from "../../tests/e2e/browser.mjs";
import { kSchool, openSchool } from "../../tests/e2e/school/open.mjs";
import { axeViolations, clicksToGradeAWall, keysToGrade } from "./grading_figures.mjs";
import { openAttempt, workersOf } from "./opening.mjs";
import { instructor, startSchool } from "./real_school.mjs";

const kSkipped = 77;
const kMaxLost = "Outline";

// Of scripts and style as they travel (compressed), and of clicks; raised only on purpose.
const kBudget = { sign_in_bytes: 52_400, list_bytes: 86_800, attempt_bytes: 176_300, clicks: 12 };

function option(name) {
  const at = process.argv.indexOf(name);
  return at < 0 ? undefined : process.argv[at + 1];
}

// Everything below /assets/ that came over the line, each once.
async function countBytes(page) {
  const session = await page.context().newCDPSession(page);
  const kinds = new Map();
  const bytes = { assets: 0, api: 0 };
  session.on("Network.responseReceived", ({ requestId, response }) =>
    kinds.set(requestId, new URL(response.url).pathname.startsWith("/api/") ? "api" : "assets"),
  );
  session.on("Network.loadingFinished", ({ requestId, encodedDataLength }) => {
    bytes[kinds.get(requestId) ?? "assets"] += encodedDataLength;
  });
  await session.send("Network.enable");
  return bytes;
}

// Who lost most on a criterion, when it happened, a remark there, another score, and on to the
// next.
async function grade(page, most) {
  let clicks = 0;
  const click = async (locator) => {
    ++clicks;
    await locator.click();
  };
  await click(page.getByRole("link", { name: "Assignments", exact: true }));
  await click(page.getByRole("link", { name: /^Grade/ }).first());
  await page.locator("table.grading .lost-much, table.grading .lost-some").first().waitFor();
  await click(page.getByRole("button", { name: most, exact: true }));
  await click(page.locator("table.grading tr", { hasText: "To release" }).first().locator("th a"));
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".plot canvas").waitFor();
  await click(page.locator(".mistakes button").first());
  const remark = page.getByLabel(/New remark/);
  await click(remark);
  await remark.fill("The wall was cut too far here.");
  await click(page.getByRole("button", { name: "Add remark" }));
  await page.locator(".annotation").first().waitFor();
  await click(page.getByRole("button", { name: "Override score…" }));
  const score = page.getByLabel("New score, 0 to 100");
  await click(score);
  await score.fill("61.5");
  const reason = page.getByLabel("Reason");
  await click(reason);
  await reason.fill("One wall.");
  await click(page.getByRole("button", { name: "Set this score" }));
  await page.getByText("61.5 instead of").waitFor();
  const before = page.url();
  await click(page.getByRole("button", { name: "Release, then next" }));
  await page.waitForFunction((url) => location.href !== url, before);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  return clicks;
}

async function measure(browser, { baseUrl, login, password, most }) {
  const page = await newPage(browser, baseUrl);
  const errors = await begin(page);
  const bytes = await countBytes(page);
  const found = {};
  await page.goto("/");
  await page.getByLabel("Login").waitFor();
  await page.waitForLoadState("networkidle");
  found.sign_in_bytes = bytes.assets;
  await page.getByLabel("Login").fill(login);
  await page.getByLabel("Password").fill(password);
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.locator("main table").first().waitFor();
  await page.waitForLoadState("networkidle");
  const clicks = await grade(page, most).catch(async (error) => {
    await page.screenshot({ path: "build/budget_failed.png" }).catch(() => {});
    throw error;
  });
  for (const [, size] of await workersOf(page)) bytes.assets += size;
  if (errors.length > 0) throw new Error(`errors in the browser's console: ${errors.join("; ")}`);
  return { found, bytes, clicks };
}

// The first list needs the staff's part; the attempt what draws.
async function listBytes(browser, { baseUrl, login, password }) {
  const page = await newPage(browser, baseUrl);
  const bytes = await countBytes(page);
  await page.goto("/assignments");
  await page.getByLabel("Login").fill(login);
  await page.getByLabel("Password").fill(password);
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.locator("main table").first().waitFor();
  await page.waitForLoadState("networkidle");
  await page.context().close();
  return bytes.assets;
}

async function quick(dist) {
  const opened = await openSchool({ folder: option("--school") ?? kSchool, dist });
  const { login, password } = opened.school.people.instructor;
  const where = { baseUrl: opened.url, login, password, most: kMaxLost };
  const browser = await launch();
  try {
    const list = await listBytes(browser, where);
    const { found, bytes, clicks } = await measure(browser, where);
    return { ...found, list_bytes: list, attempt_bytes: bytes.assets, clicks };
  } finally {
    await browser.close();
    await opened.close();
  }
}

// A flow that comes to no end has no figure; the others keep theirs.
const orNull = (figure) =>
  figure.catch((error) => {
    console.error(error.message);
    return null;
  });

async function real(dist) {
  const school = await startSchool({ dist });
  const { url } = school;
  const browser = await launch();
  try {
    const teeth = {};
    for (const { name, attempt } of school.teeth) {
      const { found, page } = await openAttempt(browser, { url, attempt, ...instructor });
      await page.context().close();
      teeth[name] = found;
      console.log(name, found);
    }
    const worst = (name) => Math.max(...Object.values(teeth).map((tooth) => tooth[name]));
    return {
      bytes_coarse_kb: worst("bytes_coarse_kb"),
      bytes_fine_kb: worst("bytes_fine_kb"),
      coarse_s: worst("coarse_s"),
      fine_s: worst("fine_s"),
      scrub_p95_ms: worst("scrub_p95_ms"),
      longest_block_ms: Math.max(worst("block_opening_ms"), worst("block_scrubbing_ms")),
      layout_shift: worst("layout_shift"),
      warm_kb: worst("warm_kb"),
      clicks_lost_wall: await orNull(clicksToGradeAWall(browser, url)),
      keys_grade_16: await orNull(keysToGrade(browser, url)),
      tooth_height_px: Math.min(...Object.values(teeth).map((tooth) => tooth.tooth_height_px)),
      axe_violations: await orNull(axeViolations(browser, url, school.teeth[0].attempt)),
      load_of_the_machine: Math.round(10 * loadavg()[0]) / 10,
      teeth,
    };
  } finally {
    await browser.close();
    await school.close();
  }
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium (install Debian's chromium, or name another with CHROMIUM)");
  process.exit(kSkipped);
}
const dist = option("--dist") ?? fileURLToPath(new URL("../dist", import.meta.url));
const file = option("--json");
const result = file === undefined ? await quick(dist) : await real(dist);
let over = 0;
for (const [name, value] of Object.entries(result)) {
  if (typeof value !== "number") continue;
  const most = kBudget[name];
  if (most !== undefined && value > most) ++over;
  console.log(
    `${name.padEnd(20)} ${String(value).padStart(12)}${most === undefined ? "" : `   at most ${most}${value > most ? ": TOO MUCH" : ""}`}`,
  );
}
if (file !== undefined) writeFileSync(file, `${JSON.stringify(result, null, 2)}\n`);
process.exit(over === 0 ? 0 : 1);
