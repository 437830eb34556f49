// An attempt in one file, for who has no server (web/scripts/demo.mjs).
import assert from "node:assert/strict";
import { mkdtempSync, rmSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { writeDemo } from "../../web/scripts/demo.mjs";
import { differing, toothAtRest, toothPixelsBecome } from "./pixels.mjs";
import { accessible, looks } from "./session.mjs";

export const demoFlows = [
  { name: "one file shows an attempt without a server and without network", run: oneFile },
  { name: "a file is made only of a score that its student may see", run: notReleased },
  { name: "no file is made of a person's attempt", run: ofAPerson },
];

const kMaxBytes = 6e6;
const isTooDeep = ([r, g, b]) => r > 150 && r - g > 60 && r - b > 60;
const isDentin = ([r, g, b]) => r > 210 && g > 170 && b < 140;
const isMuch = (pixels) => pixels > 500;

async function withFolder(use) {
  const folder = mkdtempSync(join(tmpdir(), "enamel-demo-"));
  try {
    await use(join(folder, "demo.html"));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

const made = ({ baseUrl: server, logins, school }, name, out) =>
  writeDemo({ server, login: logins.student.login, attempt: school.attempts[name], out }, logins.student.password);

async function oneFile(world) {
  const student = await world.as("student");
  const { score, mistakes } = await student.get(`/attempts/${world.school.attempts.shown}/score`);
  await withFolder(async (out) => {
    await made(world, "shown", out);
    assert.ok(statSync(out).size < kMaxBytes, `${statSync(out).size} bytes`);
    const page = await world.open({ width: 1280, height: 800 });
    await page.context().setOffline(true);
    try {
      const asked = [];
      page.on("request", (request) => asked.push(request.url()));
      await page.goto(pathToFileURL(out).href);
      await page.getByText("This is a recorded attempt.").waitFor();
      await page.locator(".plot canvas").waitFor();
      assert.match(await page.title(), /a recorded attempt/);
      const near = (text, value) => assert.equal(Number.parseFloat(text.replace("−", "-")), Number(value.toFixed(1)));
      near(await page.getByTestId("score").innerText(), score);
      near(await page.locator(".score-card .lost").first().innerText(), -mistakes[0].points);
      await toothPixelsBecome(page, "the wall that was cut too deep", isTooDeep, isMuch);
      const after = await toothAtRest(page);
      await accessible(page, "an attempt in one file");
      await world.picture(page, "demo");
      // To its beginning, and on from there.
      await page.locator("body").click({ position: { x: 5, y: 400 } });
      await page.keyboard.press("Home");
      await page.locator('.playback[data-shown="0"]').waitFor();
      assert.ok(differing(await toothAtRest(page), after) > 0.05, "the tooth before it was cut looks otherwise");
      await page.getByRole("button", { name: "Play", exact: true }).click();
      await page.waitForFunction(() => Number(document.querySelector(".playback").dataset.shown) > 0);
      await page.getByRole("button", { name: "Pause" }).click();
      // What lies inside is of the start tooth.
      await page.getByLabel("Section", { exact: true }).selectOption("y");
      await toothPixelsBecome(page, "dentin in the section", isDentin, isMuch);
      assert.deepEqual(
        await page.locator('main a:not([href^="#"]), .notice.bad').allInnerTexts(),
        [],
        "what needs a server",
      );
      for (const [language, title] of looks(["Deutsch", "Punkte"], ["中文", "分数"])) {
        await page.getByRole("button", { name: language }).click();
        await page.getByRole("heading", { name: title, exact: true }).waitFor();
        await toothAtRest(page);
      }
      await page.setViewportSize({ width: 390, height: 844 });
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
      await world.picture(page, "demo_narrow");
      assert.deepEqual(
        asked.filter((address) => !/^(file|blob|data):/.test(address)),
        [],
      );
    } finally {
      await page.context().setOffline(false);
    }
  });
}

async function notReleased(world) {
  await withFolder((out) => assert.rejects(made(world, "unreleased", out), /expected a score that student may see/));
}

// The school has simulated hands only, so another server says of one that a person held the tool.
async function ofAPerson(world) {
  const attempt = await (await world.as("student")).get(`/attempts/${world.school.attempts.shown}`);
  const held = JSON.stringify({ ...attempt, hand: { ...attempt.hand, kind: "haptic" } });
  const server = createServer((_, answer) => answer.setHeader("Content-Type", "application/json").end(held));
  await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
  const baseUrl = `http://127.0.0.1:${server.address().port}`;
  try {
    await withFolder((out) => assert.rejects(made({ ...world, baseUrl }, "shown", out), /found a person's/));
  } finally {
    server.closeAllConnections();
    server.close();
  }
}
