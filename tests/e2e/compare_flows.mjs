// Two attempts, side by side and one over the other.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { countColors, differing, toothPixels, toothPixelsBecome } from "./pixels.mjs";
import { accessible, looks, signedIn } from "./session.mjs";

export const compareFlows = [
  { name: "two attempts are shown side by side", run: beside },
  { name: "a student sees the reference beside their own attempt", anywhere: true, run: besideTheReference },
  { name: "two teeth side by side have the same kind of colours", run: besideAlike },
  { name: "two attempts fit a small window, with nothing over the teeth", run: besideInASmallWindow },
  { name: "an attempt to compare with is found by its person and exercise", run: found },
  { name: "another attempt lies over this one, at the same time or place of the way", run: onTop },
];

const isTinted = ([r, g, b]) => g - r > 25 && g - b > -25 && b - r > 5; // by another tooth over it

async function beside(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown", "?t=30"));
  await page.locator('.playback[data-shown="300"]').waitFor();
  const choice = page.getByLabel("Compare with");
  await choice.focus();
  const other = choice.locator(`optgroup[label='By others'] option[value$="${world.school.attempts.slow}"]`);
  await other.waitFor({ state: "attached" });
  await choice.selectOption(await other.getAttribute("value"));
  await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".other-time", { hasText: "0:30.0" }).waitFor();
  // One tooth, cut by two hands: from the same side they look alike.
  await page.getByLabel("Moment of the other attempt").selectOption("removed");
  await page.locator(".other-time", { hasText: /^\d:\d\d\.\d$/ }).waitFor();
  await page.getByLabel("Moment of the other attempt").selectOption("time");
  const names = await page.locator(".tooth-name").allInnerTexts();
  assert.equal(names.length, 2);
  assert.notEqual(names[0], names[1], "each picture says whose it is");
  for (const preset of ["Lingual", "Apical"]) {
    await page.getByRole("button", { name: preset, exact: true }).click();
    await eventually(() => alike(page, preset));
  }
  // The other one may be turned too.
  await page.locator(".other-tooth .tooth-frame").focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press("ArrowRight");
  await eventually(() => alike(page, "turned by the other one"));
  await accessible(page, "two attempts");
  await world.picture(page, "beside");
  await choice.selectOption("");
  await page.locator(".other-tooth").waitFor({ state: "detached" });
}

// Of everybody and every exercise, not only among the newest of this one.
async function found(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByLabel("Compare with").selectOption({ label: "Find another…" });
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Exercise").selectOption({ label: "Class I occlusal cavity" });
  await dialog.getByLabel("Student").fill("kovacova");
  await dialog.getByRole("button", { name: "Search" }).click();
  const { score } = await (await world.as("instructor")).get(world.attempt("class3"));
  const rows = dialog.locator("tbody tr");
  const theirs = rows.filter({ hasText: /^Žofia Kováčová-Szczepańska/ });
  await theirs.filter({ hasText: score.toFixed(1) }).waitFor();
  await eventually(async () => assert.equal(await rows.count(), await theirs.count()));
  await accessible(page, "the search for an attempt");
  await theirs
    .filter({ hasText: score.toFixed(1) })
    .getByRole("button", { name: /^Compare with Žofia / })
    .click();
  await dialog.waitFor({ state: "detached" });
  await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
  assert.equal(await page.getByLabel("Compare with").inputValue(), world.school.attempts.class3);
  assert.match(await page.locator(".tooth-name").last().innerText(), /^Žofia /);
}

// Of the colours of the deviation most of a tooth has this one; of a playback at most the bur.
const isUntouched = ([r, g, b]) => r > 100 && r < 200 && b > r && b - r < 30 && Math.abs(r - g) < 16;

// On the way both show tissues, at the end both the deviation: also where the other one took longer.
async function besideAlike(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown", "?t=30"));
  await page.locator('.playback[data-shown="300"]').waitFor();
  const choice = page.getByLabel("Compare with");
  await choice.focus();
  const other = choice.locator(`option[value$="${world.school.attempts.slow}"]`);
  await other.waitFor({ state: "attached" });
  await choice.selectOption(await other.getAttribute("value"));
  await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
  const own = ".teeth > .tooth canvas";
  const both = (check) =>
    eventually(async () => {
      await page.waitForFunction(() => document.querySelectorAll("canvas[data-drawn=full]").length === 2);
      for (const canvas of [own, ".other-tooth canvas"])
        check((await countColors(page, canvas, { found: isUntouched })).found, canvas);
    });
  const coloured = (count, canvas) => assert.ok(count > 40_000, `${canvas}: ${count} pixels of untouched tooth`);
  const plain = (count, canvas) => assert.ok(count < 20_000, `${canvas}: ${count} pixels of untouched tooth`);
  await both(plain);
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("End");
  await both(coloured);
  await world.picture(page, "beside_end");
  await accessible(page, "two finished teeth");
  await page.getByLabel("Tissues").check();
  await both(plain);
  await page.getByLabel("Deviation").check();
  // One step before the end.
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("ArrowLeft");
  await both(plain);
}

async function besideTheReference(world) {
  const page = await signedIn(world, "student", "/attempts");
  const showsItsScore = page
    .locator("tbody tr")
    .filter({ hasText: "✓ Scored" })
    .filter({ hasText: /\d\.\d/ });
  await showsItsScore.first().getByRole("link").click();
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  const choice = page.getByLabel("Compare with");
  const name = await choice.locator("option", { hasText: "The reference, " }).textContent();
  await choice.selectOption({ label: name });
  await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
  await eventually(async () => assert.equal(await page.locator(".tooth-name").last().innerText(), name));
  await world.picture(page, "beside_reference");
}

// Two pictures of one tooth at one moment, but for names and tools over them.
async function alike(page, where) {
  await page.waitForFunction(() => document.querySelectorAll("canvas[data-drawn=full]").length === 2);
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
  const shown = [];
  for (const { x, y, width, height } of await boxesOf(page, ".teeth canvas")) {
    const clip = { x: Math.ceil(x), y: Math.ceil(y), width: Math.floor(width) - 1, height: Math.floor(height) - 1 };
    shown.push(await page.screenshot({ clip }));
  }
  const [own, other] = shown;
  const apart = differing(own, other);
  assert.ok(apart < 0.12, `${where}: ${apart} of the two pictures differs`);
}

// Of the visible ones, in the window's pixels.
async function boxesOf(page, selector) {
  return page.locator(selector).evaluateAll((found) =>
    found
      .map((element) => element.getBoundingClientRect())
      .filter((box) => box.width > 1)
      .map((box) => box.toJSON()),
  );
}

const kTools = ".tooth-tools .button, .tooth-tools select, .tooth-tools [type=range], .tooth-tools .segmented label";

// The tools are beside the teeth and inside the card, no tool covers another, and the plot's axis
// is in view.
async function fitsBesideTheTeeth(page, height, where) {
  const [teeth, tools, [card], [plot]] = [
    await boxesOf(page, ".tooth-frame"),
    await boxesOf(page, kTools),
    await boxesOf(page, ".tooth-card"),
    await boxesOf(page, ".force-card .plot canvas"),
  ];
  const apart = (a, b) =>
    a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
  assert.ok(tools.length > 10, `${where}: ${tools.length} tools`);
  for (const [i, tool] of tools.entries()) {
    const text = `${where}: a tool from ${tool.left}, ${tool.top} to ${tool.right}, ${tool.bottom}`;
    for (const tooth of teeth) assert.ok(apart(tool, tooth), `${text} over a tooth`);
    for (const other of tools.slice(i + 1))
      assert.ok(apart(tool, other), `${text} over another, from ${other.left}, ${other.top}`);
    assert.ok(
      tool.left >= card.left && tool.right <= card.right && tool.height >= 18,
      `${text} beyond the card, or too low`,
    );
  }
  for (const tooth of teeth)
    assert.ok(tooth.width >= 300 && tooth.height >= 260, `${where}: a tooth of ${tooth.width} x ${tooth.height}`);
  assert.ok(plot.bottom <= height + 1, `${where}: the plot ends at ${plot.bottom} of ${height}`);
}

async function besideInASmallWindow(world) {
  for (const [width, height, colorScheme, languages] of looks(
    [1280, 720, "light", ["de"]],
    [1280, 720, "light", ["en", "zh"]],
    [1280, 720, "dark", ["en"]],
    [1440, 900, "light", ["en"]],
  )) {
    const page = await signedIn(world, "instructor", world.attempt("shown"), { width, height, colorScheme });
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    for (const language of languages) {
      if (language !== "en") {
        await page.goto("/account");
        await page.locator("main select").selectOption(language);
        await page.locator(`html[lang^=${language}]`).waitFor();
        await page.goto(world.attempt("shown"));
        await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
      }
      const choice = page.locator(".tooth-choices select").last();
      await choice.focus();
      await choice.locator("optgroup option").first().waitFor({ state: "attached" });
      await choice.selectOption({ label: await choice.locator("optgroup option").first().textContent() });
      await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
      const where = `${language} ${colorScheme} at ${width} x ${height}`;
      await fitsBesideTheTeeth(page, height, `${where}, side by side`);
      await world.picture(page, `beside_${language}_${width}_${colorScheme}`);
      await page.locator(".tooth-choices select").first().selectOption("x");
      await fitsBesideTheTeeth(page, height, `${where}, cut open`);
      await page.locator(".compare-bar input[value=top]").check({ force: true });
      await page.locator(".other-tooth").waitFor({ state: "detached" });
      await fitsBesideTheTeeth(page, height, `${where}, on top`);
    }
  }
}

async function putOnTop(page, other) {
  const choice = page.getByLabel("Compare with");
  await choice.focus();
  const option = choice.locator(`option[value$="${other}"]`);
  await option.waitFor({ state: "attached" });
  await choice.selectOption(await option.getAttribute("value"));
  await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByLabel("On top", { exact: true }).check();
  await page.locator(".other-tooth").waitFor({ state: "detached" });
  await page.getByText("Other: more left").waitFor();
}

// The visible part of the picture's card fits the window, and the legend takes one line.
async function barFits(page, height) {
  const bar = await page.locator(".compare-bar").boundingBox();
  const plot = await page.locator(".force-card .u-over").boundingBox();
  assert.ok(bar.height < 40, `the bar is ${bar.height} high`);
  assert.ok(plot.y + plot.height <= height, `the plot ends at ${plot.y + plot.height} of ${height}`);
}

// Halfway through, the others of the class have cut other places than this one; at the end what is left between the two
// is the mesial wall, which this one cut 0.3 mm too far.
async function onTop(world) {
  for (const [width, height] of looks([1280, 720], [1440, 900])) {
    const page = await signedIn(world, "instructor", world.attempt("shown", "?t=20"), { width, height });
    await page.locator('.playback[data-shown="200"]').waitFor();
    await page.getByRole("button", { name: "Cavity", exact: true }).click();
    const before = await toothPixels(page, isTinted);
    await putOnTop(page, world.school.attempts.slow);
    await page.locator(".other-time", { hasText: "0:20.0" }).waitFor();
    await toothPixelsBecome(page, "other, on top", isTinted, (count) => count > before + 300);
    await page.getByRole("application", { name: /The other attempt is drawn on top/ }).waitFor();
    await barFits(page, height);
    await accessible(page, `another attempt on top at ${width}`);
    await world.picture(page, `on_top_${width}`);
    await page.getByLabel("Moment of the other attempt").selectOption({ label: "At the same place" });
    await page.locator(".other-time", { hasText: /^0:\d\d\.\d$/ }).waitFor();
    await world.picture(page, `on_top_same_place_${width}`);
    // A plane cuts both.
    await page.getByLabel("Section", { exact: true }).selectOption("y");
    await page.getByRole("button", { name: "Lingual", exact: true }).click();
    await world.picture(page, `on_top_section_${width}`);
    await page.getByLabel("Section", { exact: true }).selectOption("");
    await page.getByRole("button", { name: "Cavity", exact: true }).click();
    await page.locator("body").click({ position: { x: 5, y: 300 } });
    await page.keyboard.press("End");
    await toothPixelsBecome(page, "the wall at the end", isTinted, (count) => count > before + 100);
    await barFits(page, height);
    await world.picture(page, `on_top_end_${width}`);
    await page.getByLabel("Compare with").selectOption("");
    await page.locator(".compare-bar").waitFor({ state: "detached" });
  }
}
