// Debian's Chromium through playwright-core, with every console error and policy violation kept.
import { existsSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(new URL("../../web/package.json", import.meta.url));
const kChromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
const kTimeoutMs = 60_000;

export function chromiumIsThere() {
  return existsSync(kChromium);
}

export async function launch() {
  const { chromium } = require("playwright-core");
  return chromium.launch({
    executablePath: kChromium, headless: true,
    // Without a GPU flag WebGL 2 runs on Chromium's own software renderer.
    args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
           "--disable-sync"],
  });
}

// One person's browser: a fresh profile with its own cookies.
export async function openPage(browser, baseUrl, { width = 1440, height = 900, colorScheme = "light" } = {}) {
  const context = await browser.newContext({ baseURL: baseUrl, viewport: { width, height }, colorScheme, locale: "en-GB", reducedMotion: "reduce" });
  const page = await context.newPage();
  page.setDefaultTimeout(kTimeoutMs);
  const errors = [];
  page.on("pageerror", (error) => errors.push(`uncaught: ${error.message}`));
  page.on("console", (message) => {
    if (message.type() === "error" && !isExpected(message)) errors.push(`console: ${message.text()}`);
  });
  return { context, page, errors };
}

// Chromium logs every refused request; the flows provoke 4xx answers on purpose.
function isExpected(message) {
  return /Failed to load resource: the server responded with a status of 4\d\d/.test(message.text());
}

export async function accessibilityViolations(page) {
  const { readFileSync } = await import("node:fs");
  await page.evaluate(readFileSync(require.resolve("axe-core/axe.min.js"), "utf8"));
  const result = await page.evaluate(() => globalThis.axe.run(document, {
    runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] }));
  return result.violations.map(({ id, help, nodes }) => `${id}: ${help} (${nodes.map((node) => node.target.join(" ")).slice(0, 4).join(", ")})`);
}
