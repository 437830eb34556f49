// How many clicks and keys it takes to grade the class of a real school (real_school.mjs), and what axe finds.
import { accessibilityViolations } from "../../tests/e2e/browser.mjs";
import { signedInPage } from "./opening.mjs";
import { instructor, kClass, kCohort } from "./real_school.mjs";
import { kLanguages } from "./words.mjs";

const kMaxLost = "Outline";
const kFine = ".tooth-frame[data-tooth=fine]";

const gradeLink = (page) =>
  page
    .locator("main tr", { hasText: kCohort })
    .getByRole("link", { name: /^Grade/ })
    .first();

// Who lost the mesial wall, where, and the release; from the first page on.
export async function clicksToGradeAWall(browser, url) {
  const { page } = await signedInPage(browser, { url, ...instructor });
  let clicks = 0;
  const click = async (locator) => {
    ++clicks;
    await locator.click();
  };
  await page.goto("/");
  await click(page.getByRole("link", { name: "Assignments", exact: true }));
  await click(gradeLink(page));
  await page.locator("table.grading .lost-much").first().waitFor();
  await click(page.getByRole("button", { name: kMaxLost, exact: true }));
  await click(page.locator("table.grading tbody th a").first());
  await page.locator(kFine).waitFor();
  await click(page.locator(".mistakes li", { hasText: "Mesial wall" }).getByRole("button", { name: /^Show me/ }));
  const graded = page.url();
  await click(page.getByRole("button", { name: "Release, then next" }));
  await page.waitForFunction((at) => location.href !== at, graded);
  await page.locator(kFine).waitFor();
  await page.context().close();
  return clicks;
}

// From the list of the class until all are released.
export async function keysToGrade(browser, url) {
  const { page } = await signedInPage(browser, { url, ...instructor });
  await page.goto("/assignments");
  await gradeLink(page).click();
  await page.locator("table.grading tbody th a").first().focus();
  let keys = 0;
  const press = async (key) => {
    ++keys;
    const at = page.url();
    await page.keyboard.press(key);
    await page.waitForFunction((url) => location.href !== url, at);
  };
  await press("Enter");
  for (let i = 0; i < kClass; ++i) {
    await page.locator(".attempt-top .actions").waitFor();
    await press("r");
  }
  // Back at the list, and all are released.
  await page.locator("table.grading").waitFor();
  const released = await page.locator("table.grading tbody tr", { hasText: "Released" }).count();
  if (released !== kClass) throw new Error(`expected ${kClass} released, found ${released} after ${keys} keys`);
  await page.context().close();
  return keys;
}

const kScreens = [
  "/attempts",
  "/assignments",
  "/exercises",
  "/cohorts",
  "/live",
  "/stations",
  "/profiles",
  "/account",
  "/attempts?name=nobody-has-this-name",
  "/not-there",
];

// Each screen of an instructor, and an attempt with everything pressed, with an error, and after the session has
// expired: in both themes and three languages.
export async function axeViolations(browser, url, attempt) {
  const { page } = await signedInPage(browser, { url, ...instructor });
  await page.goto("/account");
  let found = 0;
  const look = async (what) => {
    await page.waitForLoadState("networkidle");
    for (const violation of await accessibilityViolations(page)) {
      console.error(`${what}: ${violation}`);
      ++found;
    }
  };
  for (const language of kLanguages) {
    await page.evaluate((chosen) => localStorage.setItem("enamel.language", chosen), language);
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      const where = (path, state = "") => `${path}${state}, ${language}, ${colorScheme}`;
      for (const path of kScreens) {
        await page.goto(path);
        await look(where(path));
      }
      const one = `/attempts/${attempt}`;
      await page.goto(one);
      await page.locator(kFine).waitFor();
      await look(where(one));
      for (const button of await page.locator(".tooth-choices button[aria-pressed]").all()) await button.click();
      await page.locator(".tooth-choices select").first().selectOption({ index: 1 });
      await page.locator(".actions [aria-expanded=false]").first().click();
      await page.locator("main details").evaluateAll((all) => {
        for (const folded of all) folded.setAttribute("open", "");
      });
      await look(where(one, ", pressed and open"));
      await page.route("**/api/v1/**", (route) => route.abort());
      await page.locator("header nav a").first().click();
      await look(where("a list without a server"));
      await page.unrouteAll();
      await page.route("**/api/v1/**", (route) =>
        route.fulfill({ status: 401, json: { error: { code: "unauthenticated", message: "Sign in.", field: "" } } }),
      );
      await page.goto(one);
      await page.locator("form input").first().waitFor();
      await look(where("signed out"));
      await page.unrouteAll();
    }
  }
  await page.context().close();
  return found;
}
