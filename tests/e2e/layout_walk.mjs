// Walks every page of every role on a real server, and looks for what nobody may ever see: text that is cut off, covered,
// outside the window, over other text, empty, in another language than the chosen one; sideways scrolling.
//   node tests/e2e/layout_walk.mjs --dist DIR [--school DIR] [--only TEXT] [--pictures DIR]
// Each page in two combinations of width, language, theme and zoom, chosen so that every two values meet somewhere
// (covering.mjs). With ENAMEL_FULL in all of them.
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { Person, until } from "../contract/client.mjs";
import { kLanguages } from "../../web/scripts/words.mjs";
import { chromiumIsThere, launch } from "./browser.mjs";
import { allOf, covering } from "./covering.mjs";
import { findings } from "./layout_findings.mjs";
import { kSchool, openSchool } from "./school/open.mjs";

const kSkipped = 77;
const kFactors = {
  width: [360, 768, 1280, 3840],
  language: kLanguages,
  theme: ["light", "dark", "contrast"],
  zoom: [1, 2],
};
// WCAG 2.2, 1.4.10: nothing has to fit into less.
const kNarrowest_px = 320;
const fits = ({ width, zoom }) => width / zoom >= kNarrowest_px;
const kEach = 2;
const kTallest_px = 12_000;
const kWindow_px = 900; // high
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

// Who, pages. An address that is a function needs the school's ids.
const kPages = {
  nobody: ["/", "/first"],
  student: [
    "/assignments",
    "/exercises",
    (w) => `/exercises/${w.exercises.graded}`,
    "/attempts",
    (w) => `/attempts/${w.attempts.released}`,
    (w) => `/attempts/${w.attempts.exam}`,
    "/account",
    "/nothing",
  ],
  student2: ["/attempts", (w) => `/attempts/${w.attempts.appealed}`, (w) => `/attempts/${w.attempts.set_aside}`],
  instructor: [
    "/attempts",
    "/assignments",
    (w) => `/assignments/${w.assignments.graded}`,
    (w) => `/assignments/${w.assignments.exam}`,
    "/exercises",
    (w) => `/exercises/${w.exercises.graded}`,
    (w) => `/attempts/${w.attempts.shown}`,
    (w) => `/attempts/${w.attempts.exam}`,
    (w) => `/attempts/${w.attempts.set_aside}`,
    "/cohorts",
    (w) => `/cohorts/${w.cohorts.first}`,
    (w) => `/grading?assignment=${w.assignments.graded}`,
    (w) => `/grading?assignment=${w.assignments.exam}`,
    (w) => `/markings/${w.begunMarking}`,
    (w) => `/markings/${w.marking}`,
    "/live",
    (w) => `/live/${w.recording}`,
    "/stations",
    "/profiles",
    "/profiles/phantom_desktop",
    (w) => `/editor?exercise=${w.exercises.graded}`,
    (w) => `/editor?rubric=${w.exercises.graded}`,
    "/account",
  ],
  admin: [
    "/people",
    (w) => `/people/${w.ids.student}`,
    "/search?q=student",
    "/roster",
    "/cohorts",
    (w) => `/cohorts/${w.cohorts.first}`,
    "/stations",
    "/profiles",
    "/profiles/falcon",
    "/editor?profile=inverse3",
    "/health",
    "/jobs",
    "/audit",
    "/exercises",
    "/assignments",
  ],
};

const kPractice = "practice-class-1-molar-46";

// What people typed into the school, which no language translates: school/make.mjs.
const kTyped = [
  ...["Here the bur leans to mesial: keep the handpiece upright.", "Good light touch in the corner."],
  ...["The mesial wall was cut on purpose: the lesion reached there. Please look at second 20."],
  ...["Too deep at this point.", "One wall.", "Preclinic, first term", "Preclinic, second term"],
  ...["Weak device", "of no real device", "Dentist One", "Dentist Two"],
];
const kWorks = ["Sturdevant’s Art and Science of Operative Dentistry", "Summitt’s Fundamentals of Operative Dentistry"];
const namesOf = ({ people, class: others }) => [...Object.values(people), ...others].map(({ name }) => name);

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
  const size = { width: Math.round(width / zoom), height: kWindow_px };
  await page.setViewportSize(size);
  await settled(page);
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  await page.setViewportSize({ ...size, height: Math.min(kTallest_px, Math.max(kWindow_px, height)) });
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
        const seen = () => page.evaluate(findings, { language, words, typed: w.typed, least_px: kWindow_px });
        const looking = async () => {
          await page.emulateMedia({ colorScheme, forcedColors, reducedMotion: "reduce" });
          await sized(page, look);
          const first = await seen();
          if (first.length === 0) return first;
          // A busy machine may not have drawn the new size yet.
          await settled(page);
          const again = await seen();
          return first.filter((finding) => again.includes(finding));
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

// The marking of the school, to its end.
async function allMarked(w) {
  for (const marker of [w.instructor, w.colleague]) {
    const { criteria, mine } = (await marker.need("GET", `/api/v1/markings/${w.marking}`)).json;
    const points = Object.fromEntries(criteria.map(({ name, max_points: most }) => [name, { points: most }]));
    for (const { id } of mine.filter(({ marked }) => !marked))
      await marker.need("POST", `/api/v1/marking-works/${id}/marks`, { body: { rating: 4, criteria: points } });
  }
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium");
  process.exit(kSkipped);
}
const dist = option("--dist") ?? fileURLToPath(new URL("../../web/dist", import.meta.url));
const only = option("--only") ?? "";
const pictures = option("--pictures");
if (pictures !== undefined) mkdirSync(pictures, { recursive: true });

const opened = await openSchool({ folder: option("--school") ?? kSchool, dist });
const found = new Map();
let count = 0;
try {
  const { school } = opened;
  const w = { ...school, url: opened.url };
  for (const who of [...Object.keys(kPages).filter((name) => name !== "nobody"), "colleague"])
    w[who] = await Person.signedIn(opened.url, who, school.people[who].login, school.people[who].password);
  const { profiles } = (await w.instructor.need("GET", "/api/v1/profiles?limit=100")).json;
  const devices = profiles.filter(({ name }) => name !== "pointer").map(({ title }) => title);
  w.typed = [...kTyped, ...kWorks, ...namesOf(school), ...devices];
  opened.attempt("Chair 1", "student", kPractice, "student", "--assignment", school.assignments.practice);
  const { json: live } = await until(
    "an attempt is being made",
    () => w.instructor.ask("GET", "/api/v1/attempts?state=recording"),
    ({ json }) => json.attempts.some(({ ticks }) => ticks > 0),
  );
  w.recording = live.attempts[0].id;
  await allMarked(w);
  const body = { marker_ids: [w.instructor.id, w.colleague.id] };
  const begun = await w.instructor.need("POST", `/api/v1/assignments/${school.assignments.blind}/markings`, { body });
  w.begunMarking = begun.json.id;
  const pages = Object.entries(kPages).flatMap(([who, all]) =>
    all.map((page) => `${who} ${typeof page === "function" ? page(w) : page}`),
  );
  const chosen = covering(pages, kFactors, { each: kEach, fits });
  if (chosen.left.length > 0) throw new Error(`no page is shown with ${chosen.left.join(", ")}`);
  const looks = process.env.ENAMEL_FULL
    ? pages.flatMap((page) => allOf(kFactors, fits).map((look) => ({ page, ...look })))
    : chosen.combinations;
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
  await opened.close();
}
for (const [finding, where] of found) console.error(`${finding}  (${where.join("; ")})`);
console.log(`${count} pages and combinations, ${found.size} findings`);
process.exit(found.size > 0 || count === 0 ? 1 : 0);
