// Blind marking: two people mark the same work without names and scores, and see what follows when both are done.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { accessible, signedIn } from "./session.mjs";

export const markingFlows = [
  { name: "two people mark an assignment blind, and see their agreement when both are done", run: blind },
  { name: "a mark that was begun outlives a reload, and a marking is given up", run: begunAndGivenUp },
  { name: "somebody else marks in the place of a marker", run: otherMarkers },
];

async function begin(page) {
  await page.getByRole("button", { name: "Begin a blind marking…" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Instructor One").check();
  await dialog.getByLabel("Instructor Two").check();
  await accessible(page, "who marks");
  await dialog.getByRole("button", { name: "Begin", exact: true }).click();
  await dialog.waitFor({ state: "detached" });
  await page.locator("a[href^='/markings/']").click();
  await page.getByRole("heading", { level: 1, name: /^Blind marking: / }).waitFor();
}

// The rest of somebody's work, without the page.
async function markTheRest(page, rating) {
  const { request } = page.context();
  const { csrf } = await (await request.get("/api/v1/session")).json();
  const marking = await (await request.get(`/api/v1${new URL(page.url()).pathname}`)).json();
  const full = Object.fromEntries(marking.criteria.map(({ name, max_points: points }) => [name, { points }]));
  for (const [i, work] of marking.mine.entries()) {
    if (work.marked) continue;
    const answer = await request.post(`/api/v1/marking-works/${work.id}/marks`, {
      headers: { "X-Enamel-Csrf": csrf },
      data: { rating: 1 + ((rating + i) % 5), criteria: full },
    });
    assert.equal(answer.status(), 204);
  }
}

async function blind(world) {
  const page = await signedIn(world, "colleague", world.assignment("blind"));
  await begin(page);
  const address = new URL(page.url()).pathname;
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  const text = await page.locator("main").innerText();
  assert.ok(!/Student \w+/.test(text), "no name is seen");
  assert.equal(await page.getByLabel("Points for Outline").count(), 0, "points come after the rating");
  await accessible(page, "a work before its rating");
  await page.keyboard.press("3");
  await eventually(async () => assert.ok(await page.getByLabel("Clear pass").isChecked()));
  await page.getByLabel("Points for Outline").fill("160");
  await page.getByRole("button", { name: "Full marks for the rest" }).click();
  await eventually(async () =>
    assert.ok(await page.getByRole("button", { name: "Give this mark" }).isDisabled(), "more than full marks"),
  );
  await page.getByText("1 criterion has no valid points yet.").waitFor();
  await page.getByLabel("Points for Outline").fill("3.5");
  await page.getByLabel("Comment on Outline").fill("cut too far");
  await accessible(page, "a work with its points");
  await world.picture(page, "blind_mark", { fullPage: true });
  await page.getByLabel("Moment", { exact: true }).fill("0");
  await page.locator(".work-time", { hasText: /^0/ }).waitFor();
  await page.getByRole("button", { name: "Give this mark" }).click();
  await page.getByRole("heading", { level: 2, name: "Work 2" }).waitFor();
  await page.getByRole("button", { name: "Work 1", exact: true, disabled: true }).waitFor();
  await page.keyboard.press("n");
  await page.getByRole("heading", { level: 2, name: "Work 3" }).waitFor();
  await page.keyboard.press("p");
  await page.getByRole("heading", { level: 2, name: "Work 2" }).waitFor();
  await page.keyboard.press("2");
  await eventually(async () => assert.equal(await page.locator("datalist option[value='cut too far']").count(), 1));
  await markTheRest(page, 1);
  await page.reload();
  await page.getByText("You have marked everything").waitFor();
  await accessible(page, "waiting for the others");
  const other = await signedIn(world, "instructor", address);
  await other.getByRole("heading", { level: 2, name: "Work 1" }).waitFor();
  await markTheRest(other, 2);
  await page.getByRole("button", { name: "Look again" }).click();
  await page.getByText("No pass mark follows from 3 attempts: it needs at least 8").waitFor();
  await accessible(page, "the results of a marking");
  await world.picture(page, "blind_results", { fullPage: true });
  const saved = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save as CSV" }).click();
  assert.match((await saved).suggestedFilename(), /marks.*\.csv$/);
  await page.goto(world.assignment("blind"));
  await page.getByText("Everybody is done").waitFor();
}

async function begunAndGivenUp(world) {
  const page = await signedIn(world, "colleague", world.assignment("blind"));
  await begin(page);
  await page.getByLabel("Borderline").check();
  await page.getByLabel("Points for Outline").fill("3");
  await page.reload();
  await eventually(async () => assert.equal(await page.getByLabel("Points for Outline").inputValue(), "3"));
  await eventually(async () => assert.ok(await page.getByLabel("Borderline").isChecked()));
  const address = page.url();
  await page.goto(world.assignment("blind"));
  await page.getByRole("button", { name: "Give up…" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Give up", exact: true }).click();
  await page.getByRole("cell", { name: "Given up", exact: true }).waitFor();
  await page.goto(address);
  await page.getByText("Nothing can be marked any more.").waitFor();
}

async function otherMarkers(world) {
  const page = await signedIn(world, "admin", world.assignment("marked"));
  await page.getByRole("cell", { name: /Instructor One: 1 of 2/ }).waitFor();
  await page.getByRole("button", { name: "Change markers…" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Instructor One").uncheck();
  await dialog.getByRole("button", { name: "Save", exact: true }).click();
  await dialog.getByText("Choose two people at least.").waitFor();
  await accessible(page, "other markers");
  await dialog.getByLabel("Admin One").check();
  await dialog.getByRole("button", { name: "Save", exact: true }).click();
  await dialog.waitFor({ state: "detached" });
  const cell = page.getByRole("cell", { name: /Admin One: 0 of 2/ });
  await cell.waitFor();
  assert.doesNotMatch(await cell.innerText(), /Instructor One/);
  const removed = await signedIn(world, "instructor", `/markings/${world.school.marking}`);
  await removed.getByText("You are not one of those who mark.").waitFor();
}
