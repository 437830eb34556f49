// Walks every page of every role on a real server, and looks for what nobody may ever see: text that is cut off, covered,
// outside the window, over other text, empty, in another language than the chosen one; sideways scrolling.
//   node tests/e2e/layout_walk.mjs --dist DIR [--only TEXT] [--pictures DIR]
// Each page in four combinations of width, language, theme and zoom, chosen so that every two values meet somewhere
// (covering.mjs). With ENAMEL_FULL in all of them.
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { startSchool } from "../contract/school.mjs";
import { chromiumIsThere, launch } from "./browser.mjs";
import { allOf, covering } from "./covering.mjs";
import { findings } from "./layout_findings.mjs";

const kSkipped = 77;
const kFactors = {
  width: [360, 768, 1280, 3840],
  language: ["en", "de", "zh"],
  theme: ["light", "dark", "contrast"],
  zoom: [1, 2],
};
// WCAG 2.2, 1.4.10: nothing has to fit into less.
const kNarrowest_px = 320;
const fits = ({ width, zoom }) => width / zoom >= kNarrowest_px;
const kEach = 4;
const kTallest_px = 12_000;
const kPoll_ms = 50;
const kPicture_ms = 2000;
const kMost_ms = 180_000; // of one page in one combination

// Says where it was, should the browser no longer answer.
async function within(what, work) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`${what}: no answer after ${kMost_ms} ms`)), kMost_ms);
  });
  try {
    return await Promise.race([work, late]);
  } finally {
    clearTimeout(timer);
  }
}
const kDocumentLanguages = { en: "en", de: "de", zh: "zh-Hans" };

// Role, pages. An address that is a function needs the school's ids.
const kPages = {
  nobody: ["/", "/first"],
  sam: [
    "/assignments",
    "/exercises",
    (w) => `/exercises/${w.exercise}`,
    "/attempts",
    (w) => `/attempts/${w.scored}`,
    "/account",
    "/nothing",
  ],
  sue: ["/attempts", (w) => `/attempts/${w.sues}`],
  ben: [
    "/attempts",
    "/assignments",
    (w) => `/assignments/${w.assignment}`,
    "/exercises",
    (w) => `/exercises/${w.exercise}`,
    (w) => `/attempts/${w.scored}`,
    (w) => `/attempts/${w.sues}`,
    "/cohorts",
    (w) => `/cohorts/${w.demo}`,
    (w) => `/grading?assignment=${w.assignment}`,
    (w) => `/markings/${w.marking}`,
    "/live",
    "/stations",
    "/profiles",
    "/profiles/phantom_desktop",
    "/editor",
    "/account",
  ],
  admin: [
    "/people",
    (w) => `/people/${w.sam.id}`,
    "/search?q=student",
    "/roster",
    "/cohorts",
    (w) => `/cohorts/${w.demo}`,
    "/stations",
    "/profiles",
    "/profiles/phantom_desktop",
    "/health",
    "/jobs",
    "/audit",
    "/exercises",
    "/assignments",
  ],
};

// The messages that are whole sentences or labels in exactly some of the languages, and the keys of all.
function wordsOf() {
  const languages = {};
  let keys = [];
  for (const language of kFactors.language)
    for (const catalogue of ["page", "exercise", "faults"]) {
      const file = new URL(`../../schemas/words/${language}/${catalogue}.json`, import.meta.url);
      const { messages } = JSON.parse(readFileSync(file, "utf8"));
      keys = [...keys, ...Object.keys(messages)];
      for (const text of Object.values(messages))
        if (typeof text === "string" && !text.includes("{"))
          languages[text.trim()] = [...new Set([...(languages[text.trim()] ?? []), language])];
    }
  return { languages, keys: [...new Set(keys)] };
}

function option(name) {
  const at = process.argv.indexOf(name);
  return at < 0 ? undefined : process.argv[at + 1];
}

async function settled(page) {
  await page.waitForFunction(
    () =>
      document.querySelector("main, form") !== null &&
      document.querySelector(".loading, [aria-busy=true]") === null &&
      document.fonts.status === "loaded",
    undefined,
    { polling: kPoll_ms },
  );
  // What the page does with the next picture. A browser that draws none, which a busy machine's may, is not waited for.
  await page.evaluate(
    (most_ms) =>
      new Promise((next) => {
        requestAnimationFrame(() => requestAnimationFrame(next));
        setTimeout(next, most_ms);
      }),
    kPicture_ms,
  );
}

// As large as the window of that zoom, and as tall as the page, so that all of it is drawn and can be asked.
async function sized(page, { width, zoom }) {
  const size = { width: Math.round(width / zoom), height: 900 };
  await page.setViewportSize(size);
  await settled(page);
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  await page.setViewportSize({ ...size, height: Math.min(kTallest_px, Math.max(900, height)) });
  await settled(page);
}

async function inLanguage(w, who, page, language) {
  if (who === "nobody") {
    await page.goto("/");
    await page.evaluate((chosen) => localStorage.setItem("enamel.language", chosen), language);
    return page.goto("/");
  }
  await w[who].need("PUT", "/api/v1/session/language", { body: { language } });
  return page.goto("/account");
}

async function walk(browser, w, who, looks, pictures) {
  const context = await browser.newContext({ baseURL: w.url, locale: "en-GB" });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  if (who !== "nobody") {
    const [name, value] = w[who].cookie.split("=");
    await context.addCookies([{ name, value, url: w.url, httpOnly: true, sameSite: "Strict" }]);
  }
  const words = wordsOf();
  const found = new Map();
  for (const language of kFactors.language) {
    await inLanguage(w, who, page, language);
    await page.locator(`html[lang=${kDocumentLanguages[language]}]`).waitFor();
    const here = looks.filter((look) => look.language === language);
    for (const address of new Set(here.map((look) => look.page))) {
      // Another page without loading all of it again, as a link would.
      await page.evaluate((path) => {
        history.pushState(null, "", path);
        dispatchEvent(new PopStateEvent("popstate"));
      }, address);
      for (const look of here.filter((one) => one.page === address)) {
        const forcedColors = look.theme === "contrast" ? "active" : "none";
        const colorScheme = look.theme === "dark" ? "dark" : "light";
        const name = `${look.width} ${language} ${look.theme} ${look.zoom}x`;
        const looking = async () => {
          await page.emulateMedia({ colorScheme, forcedColors, reducedMotion: "reduce" });
          await sized(page, look);
          return page.evaluate(findings, { language, words });
        };
        for (const finding of await within(`${who} ${address} ${name}`, looking())) {
          const key = `${who} ${address.replace(/[0-9a-f]{8}-[0-9a-f-]{27}/g, "…")}: ${finding}`;
          found.set(key, [...(found.get(key) ?? []), name]);
        }
        if (pictures !== undefined) {
          const file = `${who}_${address.replace(/[^a-z]+/g, "_").slice(0, 40)}_${name.replaceAll(" ", "_")}.png`;
          await page.screenshot({ path: join(pictures, file) });
        }
      }
    }
  }
  await context.close();
  for (const error of errors) found.set(`${who}: ${error}`, [""]);
  return found;
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium");
  process.exit(kSkipped);
}
const dist = option("--dist") ?? fileURLToPath(new URL("../../web/dist", import.meta.url));
const only = option("--only") ?? "";
const pictures = option("--pictures");
if (pictures !== undefined) mkdirSync(pictures, { recursive: true });

const { w, close } = await startSchool({ page: dist });
const found = new Map();
let count = 0;
try {
  await w.ben.need("POST", `/api/v1/attempts/${w.scored}/annotations`, {
    body: { tick: 10, text: "Look at the wall." },
  });
  const body = { marker_ids: [w.ben.id, w.admin.id] };
  w.marking = (await w.ben.need("POST", `/api/v1/assignments/${w.assignment}/markings`, { body })).json.id;
  const pages = Object.entries(kPages).flatMap(([who, all]) =>
    all.map((page) => `${who} ${typeof page === "function" ? page(w) : page}`),
  );
  const looks = process.env.ENAMEL_FULL
    ? pages.flatMap((page) => allOf(kFactors, fits).map((look) => ({ page, ...look })))
    : covering(pages, kFactors, { each: kEach, fits }).combinations;
  const browser = await launch();
  try {
    for (const who of Object.keys(kPages)) {
      const own = looks
        .filter(({ page }) => page.startsWith(`${who} `) && page.includes(only))
        .map((look) => ({ ...look, page: look.page.slice(who.length + 1) }));
      count += own.length;
      if (own.length === 0) continue;
      for (const [key, where] of await walk(browser, w, who, own, pictures)) found.set(key, where);
    }
  } finally {
    await browser.close();
  }
} finally {
  await close();
}
for (const [finding, where] of found) console.error(`${finding}  (${where.join("; ")})`);
console.log(`${count} pages and combinations, ${found.size} findings`);
process.exit(found.size > 0 || count === 0 ? 1 : 0);
