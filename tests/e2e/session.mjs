// How flows begin, and the check that most of them end with.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { accessibilityViolations } from "./browser.mjs";

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
