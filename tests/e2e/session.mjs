// How flows begin, and the check that most of them end with.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { accessibilityViolations } from "./browser.mjs";

// Of schemas/golden.
export const golden = (name) =>
  JSON.parse(readFileSync(new URL(`../../schemas/golden/${name}.json`, import.meta.url), "utf8"));

export async function signIn(page, { login, password }) {
  await page.getByLabel("Login").fill(login);
  await page.getByLabel("Password").fill(password);
  await page.getByRole("button", { name: "Sign in" }).click();
}

// Signs in without the form, which has flows of its own.
export async function signedIn(world, role, path = "/", options = {}) {
  const { login, password } = world.logins[role];
  const page = await world.open(options);
  const answer = await page.context().request.post("/api/v1/session", { data: { login, password } });
  assert.equal(answer.status(), 200, `${login} signs in`);
  await page.goto(path);
  return page;
}

// Variants of one check: all in the full run, otherwise only the first.
export const looks = (...all) => (process.env.ENAMEL_FULL ? all : all.slice(0, 1));

export async function accessible(page, where) {
  assert.deepEqual(await accessibilityViolations(page), [], `accessibility of ${where}`);
}

const kMinContrast = 4.5; // WCAG 2.2 AA, for text of this size

// Text and background of every button that can be pressed, in both themes: as it is, pressed or not, with the pointer
// on it, with it gone again, and with the focus. axe knows none of these states, and cannot see what a canvas is under.
export async function legibleWhenPressed(page, selector) {
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    for (const button of await page.locator(selector).all()) {
      for (const press of [1, 2]) {
        await button.click();
        await legible(button, `${colorScheme}, pressed ${press} times, under the pointer`);
        await page.mouse.move(0, 0);
        await legible(button, `${colorScheme}, pressed ${press} times`);
        await button.focus();
        await legible(button, `${colorScheme}, pressed ${press} times, with the focus`);
      }
    }
  }
  await page.emulateMedia({ colorScheme: "light" });
}

async function legible(button, where) {
  const [name, contrast] = await button.evaluate((element) => {
    const paint = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const luminance = (...colors) => {
      for (const color of colors) {
        paint.fillStyle = color;
        paint.fillRect(0, 0, 1, 1);
      }
      const [r, g, b] = [...paint.getImageData(0, 0, 1, 1).data]
        .map((value) => value / 255)
        .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const { color, backgroundColor } = getComputedStyle(element);
    const under = getComputedStyle(document.documentElement).getPropertyValue("--surface").trim();
    const [text, ground] = [luminance(under, backgroundColor, color), luminance(under, backgroundColor)];
    return [element.textContent, (Math.max(text, ground) + 0.05) / (Math.min(text, ground) + 0.05)];
  });
  assert.ok(contrast >= kMinContrast, `${name}, ${where}: contrast ${contrast.toFixed(2)}`);
}

// Puts a file that exists only here into a file field.
export async function chooseFile(page, label, name, text) {
  await page.getByLabel(label).setInputFiles({
    name,
    mimeType: name.endsWith(".csv") ? "text/csv" : "application/json",
    buffer: Buffer.from(text),
  });
}

// What the page gives as a file when `act` is done.
export async function downloaded(page, act) {
  const [download] = await Promise.all([page.waitForEvent("download"), act()]);
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), "utf8") };
}
