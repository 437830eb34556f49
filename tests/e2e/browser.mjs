// Debian's Chromium through playwright-core.
import { existsSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(new URL("../../web/package.json", import.meta.url));
const kChromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
const kTimeoutMs = 180_000; // on a machine that others load
const kBetweenMs = 150; // a picture of the page takes about as long

export function chromiumIsThere() {
  return existsSync(kChromium);
}

export async function launch() {
  const { chromium } = require("playwright-core");
  return chromium.launch({
    executablePath: kChromium,
    headless: true,
    // Without a GPU flag WebGL 2 runs on Chromium's own software renderer.
    args: [
      "--no-sandbox",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
    ],
  });
}

// A page of one person's browser, with a profile of its own.
export async function newPage(browser, baseURL) {
  const context = await browser.newContext({ baseURL, locale: "en-GB" });
  const page = await context.newPage();
  page.setDefaultTimeout(kTimeoutMs);
  return page;
}

// Repeats `check` until it no longer throws: what the page draws follows what was pressed a little later, on a slow
// machine much later. The last failure is the one reported.
export async function eventually(check) {
  const end = performance.now() + kTimeoutMs;
  for (;;) {
    try {
      return await check();
    } catch (error) {
      if (performance.now() > end) throw error;
      await new Promise((next) => setTimeout(next, kBetweenMs));
    }
  }
}

// Sets size and colours for a flow. Returns the list that collects every console error and policy
// violation from now on.
export async function begin(page, { width = 1440, height = 900, colorScheme = "light" } = {}) {
  await page.setViewportSize({ width, height });
  await page.emulateMedia({ media: null, colorScheme, reducedMotion: "reduce" });
  const errors = [];
  page.on("pageerror", (error) => errors.push(`uncaught: ${error.message}`));
  page.on("console", (message) => {
    if (message.type() === "error" && !isExpected(message)) errors.push(`console: ${message.text()}`);
  });
  return errors;
}

// Removes everything that a flow left in the page, except the cache.
export async function leave(page) {
  await page
    .evaluate(() => {
      localStorage.clear();
      sessionStorage.clear();
    })
    .catch(() => {}); // a file has none
  page.removeAllListeners();
  await page.unrouteAll({ behavior: "ignoreErrors" });
  await page.context().clearCookies();
  await page.goto("about:blank");
}

// Chromium logs every refused request; the flows provoke 4xx answers on purpose, and a server that is away.
function isExpected(message) {
  return /Failed to load resource: the server responded with a status of (4\d\d|503)/.test(message.text());
}

const kAxe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const kRules = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

// Returns only violations: the whole result of axe is a megabyte.
export async function accessibilityViolations(page) {
  if (!(await page.evaluate(() => "axe" in globalThis))) await page.evaluate(kAxe);
  return page.evaluate(async (rules) => {
    const { violations } = await globalThis.axe.run(document, {
      runOnly: rules,
      rules: { "label-content-name-mismatch": { enabled: true } }, // WCAG 2.5.3
      resultTypes: ["violations"],
      preload: false,
    });
    return violations.map(
      ({ id, help, nodes }) =>
        `${id}: ${help} (${nodes
          .map((node) => node.target.join(" "))
          .slice(0, 4)
          .join(", ")})`,
    );
  }, kRules);
}
