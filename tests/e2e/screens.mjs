// Every screen of the page, as each role sees it: no accessibility finding, nothing wider than the
// screen, no key of a word that is missing, a picture of each to be looked at. With ENAMEL_FULL in
// each language, both themes, on a wide and on a narrow screen; else each screen in one of three
// looks, which take turns.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { accessibilityViolations } from "./browser.mjs";
import { id } from "./mock_exercises.mjs";
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
const kScreens = {
  student: [
    ["my_work", "/assignments", "main article"],
    ["exercises", "/exercises", "main article"],
    ["exercise", `/exercises/${id(20)}`, ".tooth-frame[aria-busy=false]"],
    ["my_attempts", "/attempts", "main table"],
    ["attempt_released", `/attempts/${id(120)}`, ".annotations"],
    ["attempt_hidden", `/attempts/${id(106)}`, "main .notice"],
    ["account", "/account", "main table"],
  ],
  instructor: [
    ["attempts", "/attempts", "main table"],
    ["assignments", "/assignments", "main table"],
    ["assignment", `/assignments/${id(502)}`, ".check-list"],
    ["assignment_class", `/assignments/${id(500)}`, ".insight .tenths"],
    ["exercises_staff", "/exercises", "main table"],
    ["exercise_staff", `/exercises/${id(20)}`, ".tooth-frame[aria-busy=false]"],
    ["attempt_staff", `/attempts/${id(105)}`, ".annotations"],
    ["attempt_appeal", `/attempts/${id(121)}`, ".appeal-card form"],
    ["cohort", `/cohorts/${id(10)}`, ".grades"],
    ["grading", `/grading?assignment=${id(500)}`, "table.grading .lost-much"],
    ["marking", `/markings/${id(901)}`, ".tooth-frame[aria-busy=false]"],
    ["live", "/live", ".live-card .badge.good"],
    ["watch", `/live/${id(110)}`, ".columns .live-tool"],
    ["stations_seen", "/stations", "main table"],
    ["profile_seen", "/profiles/phantom_desktop", ".trend"],
  ],
  admin: [
    ["people", "/people", "main table"],
    ["person", `/people/${id(2)}`, "main form"],
    ["search", "/search?q=student", ".found"],
    ["roster", "/roster", "main form, main input"],
    ["cohorts", "/cohorts", "main table"],
    ["cohort_admin", `/cohorts/${id(10)}`, ".grades"],
    ["stations", "/stations", "main table"],
    ["profiles", "/profiles", "main table"],
    ["profile", "/profiles/phantom_desktop", ".trend"],
    ["profile_drawn", `/profiles/phantom_desktop?report=${id(801)}`, ".stroke-case canvas"],
    ["health", "/health", ".health"],
    ["jobs", "/jobs", "main table"],
    ["audit", "/audit", "main table"],
    ["not_found", "/nothing", "main a"],
  ],
};

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
      for (const [index, [name, address, there]] of kScreens[role].entries()) {
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

export const screenFlows = Object.keys(kScreens).map((role) => ({
  name: `every screen of the ${role} is accessible and fits wide and narrow`,
  run: screenFlow(role),
}));
