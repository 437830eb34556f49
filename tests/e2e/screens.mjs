// Every screen of the page, as each role sees it: no accessibility finding, nothing wider than the
// screen, no key of a word that is missing, a picture of each to be looked at. With ENAMEL_FULL in
// each language, both themes, on a wide and on a narrow screen; else each screen in one of three
// looks, which take turns.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { accessibilityViolations } from "./browser.mjs";
import { signedIn } from "./session.mjs";

const kFull = Boolean(process.env.ENAMEL_FULL);
// German has the longest words, so it is checked on the narrowest screen.
const kShortLooks = [
  { language: "en", width: 1280, colorScheme: "light" },
  { language: "de", width: 390, colorScheme: "dark" },
  { language: "zh", width: 1280, colorScheme: "dark" },
];
const kLooks = kFull
  ? [
      ...kShortLooks,
      { language: "en", width: 390, colorScheme: "dark" },
      { language: "de", width: 1280, colorScheme: "light" },
      { language: "zh", width: 390, colorScheme: "light" },
    ]
  : kShortLooks;
const kDocumentLanguages = { en: "en", de: "de", zh: "zh-Hans" };

const kWords = new Set(
  Object.keys(JSON.parse(readFileSync(new URL("../../schemas/words/en/page.json", import.meta.url), "utf8")).messages),
);

// name, address, what is there once it is loaded
const screensOf = (world) => ({
  student: [
    ["my_work", "/assignments", "main article"],
    ["exercises", "/exercises", "main article"],
    ["exercise", world.exercise("graded"), ".tooth-frame[aria-busy=false]"],
    ["my_attempts", "/attempts", "main table"],
    ["attempt_released", world.attempt("released"), ".annotations"],
    ["attempt_hidden", world.attempt("unreleased"), "main .notice"],
    ["account", "/account", "main table"],
  ],
  instructor: [
    ["attempts", "/attempts", "main table"],
    ["assignments", "/assignments", "main table"],
    ["assignment", world.assignment("exam"), ".check-list"],
    ["assignment_class", world.assignment("graded"), ".insight .tenths"],
    ["exercises_staff", "/exercises", "main table"],
    ["exercise_staff", world.exercise("graded"), ".tooth-frame[aria-busy=false]"],
    ["attempt_staff", world.attempt("shown"), ".annotations"],
    ["attempt_appeal", world.attempt("appealed"), ".appeal-card form"],
    ["cohort", world.cohort("first"), ".grades"],
    ["grading", world.grading("graded"), "table.grading .lost-much"],
    ["marking", `/markings/${world.school.marking}`, ".tooth-frame[aria-busy=false]"],
    ["live", "/live", "main"],
    ["stations_seen", "/stations", "main table"],
    ["profile_seen", "/profiles/phantom_desktop", "main table"],
  ],
  admin: [
    ["people", "/people", "main table"],
    ["person", `/people/${world.school.ids.student2}`, "main form"],
    ["search", "/search?q=student", ".found"],
    ["roster", "/roster", "main form, main input"],
    ["cohorts", "/cohorts", "main table"],
    ["cohort_admin", world.cohort("first"), ".grades"],
    ["stations", "/stations", "main table"],
    ["profiles", "/profiles", "main table"],
    ["profile", "/profiles/phantom_desktop", "main table"],
    ["health", "/health", ".health"],
    ["jobs", "/jobs", "main table"],
    ["audit", "/audit", "main table"],
    ["not_found", "/nothing", "main a"],
  ],
});

function screenFlow(role) {
  return async (world) => {
    const findings = [];
    const page = await signedIn(world, role, "/account");
    for (const [turn, { language, width, colorScheme }] of kLooks.entries()) {
      await page.setViewportSize({ width, height: width > 500 ? 900 : 800 });
      await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
      await page.goto("/account");
      await page.locator("main select").selectOption(language);
      await page.locator(`html[lang=${kDocumentLanguages[language]}]`).waitFor();
      for (const [index, [name, address, there]] of screensOf(world)[role].entries()) {
        if (!kFull && index % kLooks.length !== turn) continue;
        await page.goto(address);
        await page.locator(there).first().waitFor();
        await page.locator(".loading").first().waitFor({ state: "detached" });
        await world.picture(page, `${role}_${name}_${language}_${colorScheme}`, { fullPage: true });
        const keys =
          (await page.locator("body").innerText())
            .match(/\b[a-z_]+\.[a-z0-9_]+\b/g)
            ?.filter((text) => kWords.has(text)) ?? [];
        findings.push(...keys.map((key) => `${name} in ${language}: ${key} has no words`));
        const overflow = await page.evaluate(
          () => document.documentElement.scrollWidth - document.documentElement.clientWidth,
        );
        if (overflow > 0) findings.push(`${name} in ${language}: ${overflow} px wider than the screen`);
        findings.push(...(await accessibilityViolations(page)).map((finding) => `${name} in ${language}: ${finding}`));
      }
    }
    assert.deepEqual(findings, []);
  };
}

export const screenFlows = ["student", "instructor", "admin"].map((role) => ({
  name: `every screen of the ${role} is accessible and fits wide and narrow`,
  run: screenFlow(role),
}));
