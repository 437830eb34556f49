// What those who teach and run a school see of classes, server and stations, against the mock server.
import assert from "node:assert/strict";
import { accessible, downloaded, signedIn } from "./session.mjs";

const id = (number) => `00000000-0000-7000-8000-${String(number).padStart(12, "0")}`;

export const insightFlows = [
  { name: "an assignment says who has not begun, the commonest error, and who is far from the class", run: classInsight },
];

// A picture at each of the sizes that people use.
async function pictures(world, page, name) {
  for (const [width, height] of [[1440, 900], [1280, 720], [390, 800]]) {
    await page.setViewportSize({ width, height });
    await page.screenshot({ path: world.picture(`${name}_${width}`), fullPage: true });
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth), 0, `${name} at ${width}: wider than the screen`);
  }
}

async function classInsight(world) {
  const page = await signedIn(world, "instructor", `/assignments/${id(500)}`);
  const card = page.getByRole("region", { name: "The class" });
  await card.getByText("Most went wrong on").waitFor();
  assert.match(await card.locator(".facts").innerText(), /Not started\s+\d+ of \d+/);
  const waiting = card.getByRole("region", { name: "Not started" });
  assert.equal(await waiting.locator(".name-list").first().locator("li").count(), Number(/\((\d+)\)/.exec(await waiting.getByRole("heading").first().innerText())[1]));
  await card.getByRole("region", { name: "Far from the class" }).getByText(/Time .* the class/).waitFor();
  await card.getByRole("region", { name: "Those who teach" }).getByText("Instructor One").waitFor();
  await accessible(page, "the class of an assignment");
  const file = await downloaded(page, () => card.getByRole("button", { name: "Save as CSV" }).click());
  assert.match(file.text, /^\uFEFFlogin,display_name,state,attempts,score,released,failed_critically,time_s,/);
  assert.match(file.text, /student,Student One,scored,/);
  await pictures(world, page, "class");
}
