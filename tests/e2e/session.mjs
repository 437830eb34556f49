// How flows begin, and the check that most of them end with.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { accessibilityViolations } from "./browser.mjs";

export async function signIn(page, { login, password }) {
  await page.getByLabel("Login").fill(login);
  await page.getByLabel("Password").fill(password);
  await page.getByRole("button", { name: "Sign in" }).click();
}

export async function signedIn(world, role, path = "/", options = {}) {
  const { page } = await world.open(options);
  await page.goto(path);
  await signIn(page, world.logins[role]);
  await page.getByRole("button", { name: "Sign out" }).waitFor();
  return page;
}

export async function accessible(page, where) {
  assert.deepEqual(await accessibilityViolations(page), [], `accessibility of ${where}`);
}

// Puts a file that exists only here into a file field.
export async function chooseFile(page, label, name, text) {
  await page.getByLabel(label).setInputFiles({ name, mimeType: name.endsWith(".csv") ? "text/csv" : "application/json", buffer: Buffer.from(text) });
}

// What the page gives as a file when `act` is done.
export async function downloaded(page, act) {
  const [download] = await Promise.all([page.waitForEvent("download"), act()]);
  return { name: download.suggestedFilename(), text: readFileSync(await download.path(), "utf8") };
}
