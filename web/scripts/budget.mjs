// What the page costs who grades with it, in a slowed Chromium: bytes, clicks, times.
//   node scripts/budget.mjs [--dist DIR] [--json FILE]
// Without BASE_URL: against the mock server. With BASE_URL, INSTRUCTOR_LOGIN and
// INSTRUCTOR_PASSWORD: against that server, which has an assignment with scored attempts that were
// not released, judged by the criterion that MOST_LOST names (Mesial wall). It then sets a score,
// writes a remark and releases one attempt there. Ends with 1 where more bytes or clicks are needed
// than allowed, with 77 where there is no Chromium. Times are printed and never fail: they depend
// on the machine.
import { writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { begin, chromiumIsThere, launch, newPage } from "../../tests/e2e/browser.mjs";
import { people } from "../../tests/e2e/mock_world.mjs";
import { startMockServer } from "../../tests/e2e/mock_server.mjs";

const kSkipped = 77;
// A small laptop behind a school's wireless network.
const kSlower = 4;
const kNetwork = { offline: false, latency: 40, downloadThroughput: 1.25e6, uploadThroughput: 0.5e6 };

// Of scripts and style as they travel (compressed), and of clicks; raised only on purpose.
const kBudget = { sign_in_bytes: 55_000, list_bytes: 90_000, attempt_bytes: 255_000, clicks: 20 };

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
  await session.send("Network.emulateNetworkConditions", kNetwork);
  await session.send("Emulation.setCPUThrottlingRate", { rate: kSlower });
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
  const times = {};
  const timed = async (name, act) => {
    const begun = performance.now();
    await act();
    times[name] = Math.round(performance.now() - begun);
  };
  await click(page.getByRole("link", { name: "Assignments", exact: true }));
  await timed("table_ms", async () => {
    await click(page.getByRole("link", { name: /^Grade/ }).first());
    await page.locator("table.grading .lost-much, table.grading .lost-some").first().waitFor();
  });
  await click(page.getByRole("button", { name: most, exact: true }));
  await timed("tooth_ms", async () => {
    await click(
      page
        .locator("table.grading tr", { has: page.getByLabel("Not released") })
        .first()
        .locator("th a"),
    );
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    await page.locator(".plot canvas").waitFor();
  });
  await click(page.locator(".criteria button").first());
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
  await timed("next_ms", async () => {
    const before = page.url();
    await click(page.getByRole("button", { name: "Release, then next" }));
    await page.waitForFunction((url) => location.href !== url, before);
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  });
  return { clicks, times };
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
  const { clicks, times } = await grade(page, most).catch(async (error) => {
    await page.screenshot({ path: "build/budget_failed.png" }).catch(() => {});
    throw error;
  });
  if (errors.length > 0) throw new Error(`errors in the browser's console: ${errors.join("; ")}`);
  return { found, bytes, clicks, times };
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

async function main() {
  const real = process.env.BASE_URL;
  if (real !== undefined && !(process.env.INSTRUCTOR_LOGIN && process.env.INSTRUCTOR_PASSWORD)) {
    throw new Error("BASE_URL is set, so INSTRUCTOR_LOGIN and INSTRUCTOR_PASSWORD are expected; found none");
  }
  const instructor = people.find((person) => person.role === "instructor");
  const server =
    real === undefined
      ? await startMockServer({ dist: option("--dist") ?? fileURLToPath(new URL("../dist", import.meta.url)) })
      : undefined;
  const where = {
    baseUrl: real ?? server.url,
    login: process.env.INSTRUCTOR_LOGIN ?? instructor.login,
    password: process.env.INSTRUCTOR_PASSWORD ?? instructor.password,
    most: process.env.MOST_LOST ?? "Mesial wall",
  };
  const browser = await launch();
  try {
    const list = await listBytes(browser, where);
    const { found, bytes, clicks, times } = await measure(browser, where);
    return {
      against: real === undefined ? "mock server" : "server",
      ...found,
      list_bytes: list,
      attempt_bytes: bytes.assets,
      api_bytes: bytes.api,
      clicks,
      ...times,
    };
  } finally {
    await browser.close();
    await server?.close();
  }
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium (install Debian's chromium, or name another with CHROMIUM)");
  process.exit(kSkipped);
}
const result = await main();
let over = 0;
for (const [name, value] of Object.entries(result)) {
  const most = kBudget[name];
  if (most !== undefined && value > most) ++over;
  console.log(
    `${name.padEnd(16)} ${String(value).padStart(12)}${most === undefined ? "" : `   at most ${most}${value > most ? ": TOO MUCH" : ""}`}`,
  );
}
const file = option("--json");
if (file !== undefined) writeFileSync(file, `${JSON.stringify({ ...result, budget: kBudget }, null, 2)}\n`);
process.exit(over === 0 ? 0 : 1);
