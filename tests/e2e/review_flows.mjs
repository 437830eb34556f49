// What people do with one attempt.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { countColors, differing, toothAtRest, toothPixelsBecome } from "./pixels.mjs";
import { decodePng } from "./png.mjs";
import { exited } from "./school/programs.mjs";
import { accessible, downloaded, legibleWhenPressed, looks, signedIn } from "./session.mjs";

export const reviewFlows = [
  { name: "an instructor sees score, deviation on the tooth, and forces", anywhere: true, run: instructorReviews },
  { name: "the tooth turns by keyboard and the timeline moves the tool", anywhere: true, run: toothByKeyboard },
  { name: "an attempt is played back with the tooth being cut", run: playsBack },
  {
    name: "the page fits a narrow screen and a dark scheme without an accessibility violation",
    anywhere: true,
    run: narrowAndDark,
  },
  { name: "a score that is being computed shows progress and then appears", run: scoringProgress },
  { name: "an instructor releases a graded score and the student then sees it", run: release },
  {
    name: "many mistakes and long names of criteria are readable, and their card stays beside the tooth",
    run: longNames,
  },
  { name: "a lost point leads to its moment", run: lostPointLeadsToItsMoment },
  { name: "the bur that took too much is glass over the colours of the deviation", seldom: true, run: burIsGlass },
  { name: "a pointer over the plot leaves the moment where it is, a press sets it", seldom: true, run: plotPointer },
  { name: "slider, plot and remarks share one axis of time", seldom: true, run: oneTimeAxis },
  { name: "a link opens the same moment from the same side", seldom: true, run: momentLink },
  { name: "tooth, timeline and plot are seen together without scrolling", seldom: true, run: oneViewport },
  { name: "an attempt is played back by keys, wherever the focus is", seldom: true, run: playbackKeys },
  { name: "an address with a moment beyond the end shows the end, with a note", seldom: true, run: momentBeyondTheEnd },
  { name: "a tooth is cut open along four planes", seldom: true, run: section },
  { name: "a section is filled with its tissues, and measured in its plane", seldom: true, run: filledSection },
  { name: "distances and an angle are measured by pointer and by keys", seldom: true, run: measures },
  { name: "an instructor marks an attempt as the reference", run: markReference },
  { name: "gaps and a replay that disagrees are reported", run: disturbedRecording },
];

const kScored = "✓ Scored";

// An attempt with the mesial wall 0.3 mm too far; of a server without the school the first scored attempt of a student
// that is not the reference itself.
async function openScoredAttempt(world, options = {}) {
  if (world.school !== undefined) {
    const page = await signedIn(world, "instructor", world.attempt("shown"), options);
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    await page.locator(".plot canvas").waitFor();
    return page;
  }
  const page = await signedIn(world, "instructor", "/attempts", options);
  const row = page
    .locator("tbody tr")
    .filter({ hasText: kScored })
    .filter({ hasNotText: "Reference" })
    .filter({ hasNotText: "Gaps" })
    .first();
  await row.getByRole("link").click();
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".plot canvas").waitFor();
  return page;
}

async function instructorReviews(world) {
  const page = await openScoredAttempt(world);
  const score = Number.parseFloat(await page.getByTestId("score").innerText());
  assert.ok(score > 0 && score <= 100, `score ${score}`);
  assert.match(
    await page.locator(".fingerprint").innerText(),
    /^[0-9a-f]{64}$/,
    "what the printed report is checked by",
  );
  const lost = await page
    .locator(".mistakes .lost")
    .evaluateAll((all) => all.map(({ textContent }) => Number.parseFloat(textContent.replace("−", ""))));
  assert.ok(lost.length >= 1);
  assert.deepEqual(
    lost,
    [...lost].sort((a, b) => b - a),
    "the dearest mistakes come first",
  );
  await page.getByText("Points by group").click();
  await page.locator(".groups summary", { hasText: "Outline" }).click();
  await page.locator(".parts tr", { hasText: "Mesial wall" }).waitFor();
  await accessible(page, "an attempt");
  await world.picture(page, "attempt", { fullPage: true });
  await heatMapIsThere(page);
  await plotIsThere(page);
}

// A mistake has a line with its moment; a click puts timeline and tooth there.
async function lostPointLeadsToItsMoment(world) {
  const page = await openScoredAttempt(world);
  const slider = page.getByRole("slider", { name: /moment|time/i }).first();
  const before = await slider.inputValue();
  await page
    .getByRole("button", { name: /^Show me Mesial wall: over-extended .* too much[;,] .*\d:\d\d\.\d.* stroke \d+/ })
    .click();
  await eventually(async () => assert.notEqual(await slider.inputValue(), before, "the timeline moves"));
  await world.picture(page, "lost_point", { fullPage: true });
  // The graded exercise has two.
  await page.goto(world.attempt("released"));
  await page.getByText(/^On this device the force was off by [1-9]\d* % in these strokes/).waitFor();
  await page.getByRole("heading", { name: "Compared with 2 dentists" }).waitFor();
  await page.getByText(/The closest cut is by Dentist (One|Two)/).waitFor();
  await accessible(page, "an attempt among dentists");
}

// Clear but for its outline: what is seen through it has the colours that it has without it.
async function burIsGlass(world) {
  const page = await openScoredAttempt(world);
  await page.locator(".playback[data-shown]").waitFor();
  const isOutline = ([r, g, b]) => r < 75 && g < 85 && b < 100;
  const counted = async () => {
    await toothAtRest(page);
    return countColors(page, ".tooth-frame canvas", { deep: isDeep, outline: isOutline });
  };
  await page.getByRole("button", { name: /^Show me Mesial wall: over-extended .* too much/ }).click();
  await page.locator(".way-back").waitFor({ state: "attached" });
  const shown = await counted();
  await world.picture(page, "glass_bur");
  await accessible(page, "a bur of glass");
  // From the same place without it.
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("End");
  await page.getByText("After the attempt").waitFor();
  const alone = await counted();
  const found = JSON.stringify({ shown, alone });
  assert.ok(shown.outline > alone.outline + 1500, found);
  assert.ok(shown.deep > 0.8 * alone.deep && alone.deep > 5000, found);
}

// Names and values as a school may write them, and two places for each.
async function longNames(world) {
  const kNames = ["Approximalflächenbeschädigung", "Convergence of the walls, as a mean around the whole outline"];
  const page = await signedIn(world, "instructor", "/");
  await page.route(/\/attempts\/[^/]+\/score$/, async (route) => {
    const response = await route.fetch({ maxRetries: 3 });
    const score = await response.json();
    const [place] = score.deductions;
    const [mistake] = score.mistakes;
    score.mistakes = Array.from({ length: 12 }, () => mistake);
    score.deductions = score.mistakes.flatMap((_, i) => [true, false].map((left) => ({ ...place, mistake: i, left })));
    const hand = score.criteria.filter(({ group }) => group === "hand");
    for (const [i, each] of hand.entries()) Object.assign(each, { title: kNames[i % 2], lost: 0.3 * each.most });
    await route.fulfill({ response, json: score });
  });
  await page.goto(world.attempt("shown"));
  await page.locator(".mistakes li").first().waitFor();
  await page.evaluate(() => {
    for (const details of document.querySelectorAll(".score-card details")) details.open = true;
  });
  for (const width of [1440, 1024, 390]) {
    await page.setViewportSize({ width, height: 800 });
    await eventually(async () => readableNames(await page.evaluate(nameBoxes), width));
  }
}

function nameBoxes() {
  const box = (element) => element.getBoundingClientRect();
  const isCut = ({ scrollWidth, clientWidth }) => scrollWidth > clientWidth;
  return {
    names: [...document.querySelectorAll(".mistake b, .parts tbody th")].map((name) => ({
      width: box(name).width,
      cut: [name, ...name.children].some(isCut),
    })),
    card: box(document.querySelector(".score-card")),
    tooth: box(document.querySelector(".review-tooth")),
    whole: document.documentElement.scrollWidth,
  };
}

function readableNames({ names, card, tooth, whole }, width) {
  for (const name of names) assert.ok(name.width > 100 && !name.cut, `${width} px: ${JSON.stringify(name)}`);
  assert.ok(card.right <= tooth.left || card.top >= tooth.bottom, `${width} px: the score is under the tooth`);
  assert.ok(whole <= width, `${width} px: the page scrolls sideways`);
}

async function plotPointer(world) {
  const page = await openScoredAttempt(world);
  const slider = page.getByLabel("Time in the attempt");
  await page.locator(".force-card .u-over").scrollIntoViewIfNeeded();
  const box = await page.locator(".force-card .u-over").boundingBox();
  await page.mouse.move(box.x + 0.2 * box.width, box.y + box.height / 2);
  await page.mouse.move(box.x + 0.7 * box.width, box.y + box.height / 2, { steps: 5 });
  await page.locator(".plot-hover").waitFor();
  await eventually(async () =>
    assert.equal(
      await slider.inputValue(),
      await slider.getAttribute("max"),
      "passing over it is no choice: it stays at the end",
    ),
  );
  await page.mouse.down();
  await page.mouse.up();
  const set = await eventually(async () => {
    const step = Number(await slider.inputValue());
    assert.ok(Math.abs(step / Number(await slider.getAttribute("max")) - 0.7) < 0.01, `step ${step}`);
    return step;
  });
  await page.mouse.move(box.x + 0.1 * box.width, box.y + box.height / 2, { steps: 5 });
  await eventually(async () => assert.equal(Number(await slider.inputValue()), set));
}

// Where the plot draws a moment, there its mark stands and there is the slider's thumb.
async function oneTimeAxis(world) {
  for (const [width, height] of looks([390, 844], [1440, 900])) {
    const page = await signedIn(world, "instructor", world.attempt("shown"), { width, height });
    await page.locator(".plot canvas").waitFor();
    const slider = page.getByLabel("Time in the attempt");
    const centre = ({ x, width: wide }) => x + wide / 2;
    for (const mark of await page.getByRole("group", { name: "Remarks on the timeline" }).getByRole("button").all()) {
      await mark.click();
      await eventually(async () => {
        const at = centre(await page.locator(".plot-cursor").boundingBox());
        const thumb = (await slider.boundingBox()).x + thumbIn(await slider.screenshot());
        const marked = centre(await mark.boundingBox());
        const where = `at ${width}: the plot's cursor is at ${at}`;
        assert.ok(Math.abs(marked - at) < 2, `${where}, the mark at ${marked}`);
        assert.ok(Math.abs(thumb - at) < 2, `${where}, the slider's thumb at ${thumb}`);
      });
    }
  }
}

async function momentLink(world) {
  const path = world.attempt("shown");
  const page = await signedIn(world, "instructor", path);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".playback").waitFor();
  const whole = await page.locator(".playback").getAttribute("data-shown");
  await page.getByLabel("Time in the attempt").fill("700");
  await page.getByRole("button", { name: "Buccal", exact: true }).click();
  const shown = await eventually(async () => {
    const frame = await page.locator(".playback").getAttribute("data-shown");
    assert.notEqual(frame, whole, "the playback follows");
    return frame;
  });
  // Before the address takes a row of its own, which moves the picture by a fraction of a pixel.
  const before = await toothAtRest(page);
  await page.getByRole("button", { name: "Link to this moment" }).click();
  const link = await page.locator(".moment-link code").innerText();
  assert.match(link, /\?t=[\d.]+&view=-?[\d.]+(_-?[\d.]+){5}$/);
  assert.equal(
    Math.floor(10 * Number(/t=([\d.]+)/.exec(link)[1])),
    Number(shown),
    "the link's moment is the one shown",
  );
  await page.goto(link);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.waitForFunction(() => document.querySelector("#timeline")?.value === "700");
  await page.locator(`.playback[data-shown="${shown}"]`).waitFor();
  // The address has four decimals: edges may fall a pixel aside.
  const apart = async () => differing(before, await page.locator(".tooth-frame canvas").screenshot());
  await eventually(async () => assert.ok((await apart()) < 0.02, "the link shows the same picture"));
  await page.getByRole("button", { name: "Mesial", exact: true }).click();
  await eventually(async () => assert.ok((await apart()) > 0.05, "another side is another picture"));
}

// In frames of a tenth of a second.
async function playbackKeys(world) {
  const page = await signedIn(world, "student", world.attempt("shown", "?t=30"));
  const at = (frames) => page.locator(`.playback[data-shown="${frames}"]`).waitFor();
  await at(300);
  await page.locator(".playback-time", { hasText: "0:30.0" }).waitFor();
  await page.keyboard.press(".");
  await at(301);
  await page.keyboard.press("j");
  await at(251);
  await page.keyboard.press("End");
  await at(world.end.frames);
  await page.keyboard.press("Home");
  await at(0);
  // On a button, on the tooth and on a choice they act as well; there the arrows are the tooth's
  // and the choice's own.
  await page.getByRole("button", { name: "Print" }).focus();
  await page.keyboard.press("l");
  await at(50);
  await page.locator(".tooth-frame").focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("L");
  await at(100);
  await page.locator(".playback-speed select").focus();
  await page.keyboard.press("l");
  await at(150);
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("ArrowLeft");
  await at(149);
  await page.keyboard.press("[");
  await page.keyboard.press("l");
  await at(199);
  await page.keyboard.press("]");
  await page.getByText("Repeating 0:14.9 to 0:19.9").waitFor({ state: "attached" });
  await page.getByText("Figures for 0:14.9 to 0:19.9").click();
  await page.getByRole("columnheader", { name: "95 % below" }).waitFor();
  const saved = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save this range as CSV" }).click();
  assert.match((await saved).suggestedFilename(), /^attempt_0_14\.9_to_0_19\.9\.csv$/);
  await accessible(page, "a loop");
  await world.picture(page, "loop");
  await page.keyboard.press("\\");
  await page.locator(".playback-loop").waitFor({ state: "detached" });
  // On a button it presses that.
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("Space");
  await page.getByRole("button", { name: "Pause", exact: true }).waitFor();
  await page.keyboard.press("k");
  await page.getByRole("button", { name: "Play", exact: true }).waitFor();
  await page.keyboard.press("?");
  const help = await page.getByRole("dialog").innerText();
  for (const what of [
    "Play and pause",
    "5 seconds back",
    "One frame forward",
    "Repeat from here (A)",
    "Faster",
    "To the end",
  ])
    assert.ok(help.includes(what), what);
  await accessible(page, "the list of keys");
  // In a text they are letters.
  const teacher = await signedIn(world, "instructor", world.attempt("shown", "?t=20"));
  await teacher.locator('.playback[data-shown="200"]').waitFor();
  await teacher.getByLabel(/New remark/).pressSequentially("jkl. [");
  await eventually(async () => assert.equal(await teacher.getByLabel(/New remark/).inputValue(), "jkl. ["));
  await eventually(async () => assert.equal(await teacher.locator(".playback").getAttribute("data-shown"), "200"));
}

async function momentBeyondTheEnd(world) {
  const page = await signedIn(world, "student", world.attempt("shown", "?t=90"));
  const { text, frames } = world.end;
  await page.getByText(`The link points to 1:30.0, but the attempt ends at ${text}. Showing the end.`).waitFor();
  await page.locator(`.playback[data-shown="${frames}"]`).waitFor();
  await accessible(page, "a moment beyond the end");
}

async function section(world) {
  const page = await signedIn(world, "student", world.attempt("shown"));
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".tooth-card .legend-scale").waitFor(); // the tooth has its colours, which come later
  await page.getByRole("button", { name: "Cavity", exact: true }).click();
  const whole = await toothAtRest(page);
  let before = whole;
  for (const [across, name] of [
    ["y", "mesio-distal"],
    ["x", "bucco-lingual"],
    ["z", "horizontal"],
    ["view", "along"],
  ]) {
    await page.getByLabel("Section", { exact: true }).selectOption(across);
    const cut = await eventually(async () => {
      const shown = await toothAtRest(page);
      assert.ok(differing(whole, shown) > 0.02, `the ${name} section shows`);
      assert.ok(differing(before, shown) > 0.005, `the ${name} section is not the one before`);
      return shown;
    });
    await page.getByLabel("Position of the section").fill("25");
    await eventually(async () => {
      before = await toothAtRest(page);
      assert.ok(differing(cut, before) > 0.005, `the ${name} section moves`);
    });
    await world.picture(page, `section_${across}`);
  }
  await page.getByRole("button", { name: "Other side" }).click();
  await accessible(page, "a section");
  await legibleWhenPressed(page, ":is(.tooth-choices, .playback-ab) .button[aria-pressed]:enabled");
  await page.getByLabel("Section", { exact: true }).selectOption("");
  await page.getByRole("button", { name: "Cavity", exact: true }).click(); // a section is looked at straight
  await eventually(async () => assert.ok(differing(whole, await toothAtRest(page)) < 0.01, "and it is whole again"));
}

const near = (hex) => (pixel) =>
  pixel.every((value, i) => Math.abs(value - Number.parseInt(hex.slice(1 + 2 * i, 3 + 2 * i), 16)) < 10);
const isDentin = near("#e2bb74");
const isTarget = near("#6d28d9");

async function filledSection(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByRole("radio", { name: "Deviation" }).waitFor();
  // Without the tissues the cut is filled all the same, and the page says why in one colour.
  await page.route("**/api/v1/start-teeth/*", (route) => route.fulfill({ body: "cut short" }));
  await page.getByLabel("Section", { exact: true }).selectOption("y");
  await page.getByText(/^The tissues cannot be shown: /).waitFor();
  await page.unroute("**/api/v1/start-teeth/*");
  await page.getByLabel("Section", { exact: true }).selectOption("");
  await page.getByLabel("Section", { exact: true }).selectOption("y");
  await page.locator(".section-legend").getByText("Dentin").waitFor();
  await toothPixelsBecome(page, "dentin in the cut", isDentin, (count) => count > 5000);
  await toothPixelsBecome(page, "the target's outline", isTarget, (count) => count > 200);
  await page.getByRole("button", { name: "Outline the reference" }).click();
  await page.locator(".section-legend").getByText("Other attempt").waitFor();
  // As long as the scale says.
  await page.getByRole("button", { name: "Measure", exact: true }).click();
  const said = page.locator(".measured");
  await said.getByText("Click the first point").waitFor();
  await page.locator(".tooth-frame canvas[data-drawn=full]").waitFor();
  const { width, height } = await page.locator(".tooth-frame").boundingBox();
  await page.locator(".tooth-frame").click({ position: { x: 0.4 * width, y: 0.8 * height } });
  await said.getByText("Click the second point").waitFor();
  await page.locator(".tooth-frame").click({ position: { x: 0.6 * width, y: 0.8 * height } });
  const found = /([\d.]+)\u00a0mm/.exec(await said.getByText(/^a to b: /).innerText());
  const scale = page.locator(".tooth-scale");
  const perMm =
    (await scale.evaluate((bar) => bar.getBoundingClientRect().width)) / Number.parseFloat(await scale.innerText());
  const [expected, measured] = [(0.2 * width) / perMm, Number(found[1])];
  assert.ok(Math.abs(measured / expected - 1) < 0.03, `${measured} mm, and ${expected} by the scale`);
  await accessible(page, "a section that is measured");
  await world.picture(page, "section_filled");
  for (const [size, scheme] of looks([[1280, 720], "dark"], [[390, 844], "light"])) {
    await page.emulateMedia({ colorScheme: scheme });
    await page.setViewportSize({ width: size[0], height: size[1] });
    await toothPixelsBecome(page, `${size} in ${scheme}`, isDentin, (count) => count > 1000);
    if (size[0] > 1000) await endsInView(page, ".section-legend", size[1]);
    await world.picture(page, `section_filled_${size[0]}_${scheme}`);
  }
}

async function endsInView(page, part, height) {
  await page.evaluate(() => scrollTo(0, 0));
  const box = await page.locator(part).boundingBox();
  assert.ok(box.y >= 0 && box.y + box.height <= height, `${part} ends at ${box.y + box.height} of ${height}`);
}

// Three points, the last two by keys; while none of it is a remark's.
async function measures(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  const tooth = page.locator(".tooth-frame");
  await page.locator(".tooth-frame[aria-busy=false] canvas[data-drawn=full]").waitFor();
  assert.match(await page.locator(".tooth-scale").textContent(), /^(0\.[125]|[125])\u00a0mm$/);
  await page.getByRole("button", { name: "Measure", exact: true }).click();
  const said = page.locator(".measured");
  await said.getByText("Click the first point").waitFor();
  const { width, height } = await tooth.boundingBox();
  await tooth.click({ position: { x: 0.45 * width, y: 0.55 * height } });
  await said.getByText("Click the second point").waitFor();
  await tooth.focus();
  await page.keyboard.press("Enter");
  await said.getByText(/^a to b: \d\.\d\d\u00a0mm/).waitFor();
  await page
    .getByRole("img", { name: /^Seen from here, the surface is at most \d\.\d\d\smm below the line/ })
    .waitFor();
  for (let i = 0; i < 3; ++i) await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("Enter");
  await said.getByText(/b to c: \d\.\d\d\u00a0mm, angle at b: \d+\.\d°/).waitFor();
  await eventually(async () => assert.deepEqual(await page.locator("span.tooth-pin").allInnerTexts(), ["a", "b", "c"]));
  await accessible(page, "measured distances");
  const saved = await downloaded(page, () => page.getByRole("button", { name: "Save the tooth as STL" }).click());
  assert.match(saved.name, /^Class_I_occlusal_cavity_practice_Student_One_\dm\d\d\.\d\.stl$/);
  assert.ok(saved.text.startsWith("Enamel, mm") && saved.text.length > 100_000, `${saved.text.length} characters`);
  const model = await downloaded(page, () => page.getByRole("button", { name: "Save the tooth as GLB" }).click());
  assert.match(model.name, /_\dm\d\d\.\d\.glb$/);
  assert.ok(model.text.startsWith("glTF") && model.text.length > 100_000, `${model.text.length} characters`);
  await world.picture(page, "measured");
  await page.keyboard.press("m");
  await said.waitFor({ state: "detached" });
  await page.keyboard.press("f");
  const onTop = page.getByRole("application", { name: /The other attempt is drawn on top/ });
  await onTop.waitFor();
  await page.keyboard.press("f");
  await onTop.waitFor({ state: "detached" });
}

async function oneViewport(world) {
  for (const [width, height] of looks([1280, 720], [1440, 900])) {
    const page = await signedIn(world, "instructor", world.attempt("shown"), { width, height });
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    await page.locator(".plot canvas").waitFor();
    for (const part of [".tooth-frame", "#timeline", ".marks", ".force-card .u-over"])
      await endsInView(page, part, height);
    const picture = await page.locator(".tooth-frame").boundingBox();
    const card = await page.locator(".tooth-card").boundingBox();
    assert.ok(picture.height >= Math.max(360, height / 2), `a picture ${picture.height} px high of ${height}`);
    assert.ok(picture.width >= 0.6 * card.width);
    for (const row of await page.locator(".mistake:visible").all())
      assert.ok((await row.boundingBox()).height < 52, `${await row.innerText()} is two lines at most`);
    // What is said of them scrolls by; they stay.
    await page.mouse.move(200, height / 2);
    await page.mouse.wheel(0, 250);
    await page.waitForFunction(() => window.scrollY > 100);
    const far = await toothAtRest(page);
    await page.getByRole("button", { name: /^Show me Mesial wall: over-extended .* too much/ }).click();
    await eventually(async () => {
      const near = await page.locator(".tooth-frame canvas[data-drawn=full]").screenshot();
      assert.ok(differing(far, near) > 0.2, "the place comes near");
    });
    const tooth = await page.locator(".tooth-frame").boundingBox();
    assert.ok(tooth.y >= 0 && tooth.y + tooth.height <= height, "the tooth is in view");
    await world.picture(page, `one_viewport_${width}`);
  }
}

// The middle of the slider's thumb in its picture, by its colour.
function thumbIn(picture) {
  const { width, height, at } = decodePng(picture);
  const columns = [];
  for (let x = 0; x < width; ++x) {
    const [r, g, b] = at(x, Math.floor(height / 2));
    if (r < 60 && g > 60 && g < 130 && b > 80 && b < 150) columns.push(x);
  }
  assert.ok(columns.length > 6 && columns.length < 24, `the thumb is ${columns.length} px wide`);
  return (columns[0] + columns.at(-1) + 1) / 2;
}

const isDeep = ([r, g, b]) => r > 130 && r > 1.6 * g && r > 1.8 * b;

// Ivory (as the reference), red (0.3 mm too far) and the neutral of untouched tooth, in view at
// once.
async function heatMapIsThere(page) {
  // A picture of the whole page changes the tooth's size: it is drawn again, and all three are looked for in one picture.
  const counts = await eventually(async () => {
    const found = await countColors(page, ".tooth-frame canvas[data-drawn=full]", {
      deep: isDeep,
      asReference: ([r, g, b]) => r > 150 && r - b > 5 && r - b < 45 && Math.abs(r - g) < 20,
      untouched: ([r, g, b]) => r > 60 && r < 230 && b > r && b - r < 30 && Math.abs(r - g) < 16,
    });
    assert.ok(found.deep > 300 && found.asReference > 300 && found.untouched > 5000, JSON.stringify(found));
    return found;
  });
  await page.getByLabel("Tissues").check();
  const isRed = ([r, g, b]) => r > 130 && r > 1.9 * g && r > 1.9 * b;
  await toothPixelsBecome(page, "red where tissues are shown", isRed, (count) => count < counts.deep / 4);
  await page.getByLabel("Deviation").check();
}

async function plotIsThere(page) {
  const counts = await countColors(page, ".plot canvas", {
    force: ([r, g, b]) => b > 90 && b > 1.4 * r && g > r,
    removed: ([r, g, b]) => r > 150 && r > 1.5 * b && g < r,
  });
  assert.ok(counts.force > 300 && counts.removed > 100, `plot: ${JSON.stringify(counts)}`);
}

// The picture, once it is another.
async function otherThan(before, canvas, what) {
  return eventually(async () => {
    const shown = await canvas.screenshot();
    assert.ok(!shown.equals(before), what);
    return shown;
  });
}

async function toothByKeyboard(world) {
  const page = await openScoredAttempt(world);
  const canvas = page.locator(".tooth-frame canvas");
  const before = await canvas.screenshot();
  await page.locator(".tooth-frame").focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press("ArrowRight");
  const turned = await otherThan(before, canvas, "arrow keys turn the tooth");
  await page.getByRole("button", { name: "Occlusal" }).click();
  const occlusal = await otherThan(turned, canvas, "a preset moves the camera");

  const timeline = page.getByLabel("Time in the attempt");
  await timeline.focus();
  await page.keyboard.press("Home"); // it opens at the end
  for (let i = 0; i < 4; ++i) await page.keyboard.press("PageUp");
  await eventually(async () => {
    assert.ok(Number(await timeline.inputValue()) > 0);
    assert.match(await timeline.getAttribute("aria-valuetext"), /^\d+:\d\d\.\d, .*largest force.*\sN/i);
  });
  await otherThan(occlusal, canvas, "the tool appears at the tooth");

  await page.getByText("Show as a table").click();
  const table = page.getByRole("group", { name: "Force and removal as a table" });
  await eventually(async () => assert.ok((await table.locator("tbody tr").count()) > 10));
  await page.getByText("Deviation in numbers").click();
  await page.getByText("Of the cut surface", { exact: false }).first().waitFor();
  await eventually(async () =>
    assert.match(
      await page.getByRole("main").innerText(),
      /Of the cut surface, \d+ % is within 0\.\d+\smm of the reference/,
    ),
  );
  await accessible(page, "an attempt with its tables open");
}

async function playsBack(world) {
  const page = await openScoredAttempt(world);
  const canvas = page.locator(".tooth-frame canvas");
  const bar = page.getByRole("group", { name: "Playback" });
  const position = bar.getByRole("slider", { name: "Playback position" });
  await position.waitFor();
  const last = await position.getAttribute("max");
  await eventually(async () => assert.equal(await position.inputValue(), last, "it begins with the tooth at the end"));
  const end = await canvas.screenshot();
  await position.fill("0");
  await page.waitForFunction(() => document.querySelector(".playback-time").innerText === "0:00.0");
  await page.locator('.playback[data-shown="0"]').waitFor();
  const start = await otherThan(end, canvas, "the tooth is the one before");
  await bar.getByRole("button", { name: "One frame forward" }).click();
  await page.waitForFunction(() => document.querySelector(".playback-time").innerText === "0:00.1");
  await position.fill("300");
  await page.locator('.playback[data-shown="300"]').waitFor();
  await otherThan(start, canvas, "something is cut and the bur is elsewhere");
  await world.picture(page, "playback", { fullPage: true });
  await accessible(page, "an attempt that is played back");
  await bar.getByLabel("Speed").selectOption("0.25");
  await page.locator(".tooth-frame").focus();
  await page.keyboard.press("k");
  await bar.getByRole("button", { name: "Pause" }).waitFor();
  await page.keyboard.press("k");
  await bar.getByRole("button", { name: "Play", exact: true }).waitFor();
  await bar.getByLabel("Speed").selectOption("16");
  await page.locator(".tooth-frame").focus();
  await page.keyboard.press("Space");
  await page.waitForFunction((frames) => document.querySelector(".playback input").value === frames, last);
  await bar.getByRole("button", { name: "Play", exact: true }).waitFor();
  await page.locator(".tooth-frame").focus();
  await page.keyboard.press("j");
  await page.waitForFunction(
    (frame) => document.querySelector(".playback input").value === frame,
    String(Number(last) - 50),
  );
}

async function narrowAndDark(world) {
  const page = await openScoredAttempt(world, { width: 390, height: 844, colorScheme: "dark" });
  const overflow = await page.evaluate(
    () => document.documentElement.scrollWidth - document.documentElement.clientWidth,
  );
  assert.ok(overflow <= 0, `the page is ${overflow} px wider than the screen`);
  await world.picture(page, "attempt_narrow_dark", { fullPage: true });
  await accessible(page, "an attempt, narrow and dark");
  const tooth = await page.locator(".tooth-frame").boundingBox();
  assert.ok(tooth.y + tooth.height < 844, `the tooth ends at ${tooth.y + tooth.height} px`);
  // A place is shown there, and there is a way back to what one pressed.
  const show = page.getByRole("button", { name: /^Show me / }).first();
  await show.click();
  await page.getByRole("button", { name: "Back to the score" }).click();
  assert.equal(await show.evaluate((button) => button === document.activeElement), true);
  assert.ok((await show.boundingBox()).y < 844);
}

async function scoringProgress(world) {
  const { opened, school } = world;
  await opened.restart("--job-threads", "0"); // what comes in waits
  const terms = ["--assignment", school.assignments.practice, "--lockstep"];
  await exited(opened.attempt("Chair 1", "student", "practice-class-1-molar-46", "timid", ...terms));
  const page = await signedIn(world, "instructor", "/attempts");
  await page.locator("tbody tr").filter({ hasText: "Waiting to be scored" }).getByRole("link").click();
  await page.getByRole("progressbar", { name: "Waiting to be scored" }).waitFor();
  await opened.restart();
  await page.getByTestId("score").waitFor();
  assert.equal(await page.getByRole("progressbar").count(), 0);
}

async function release(world) {
  const student = await signedIn(world, "student", world.attempt("unreleased"));
  await student.getByText("Not released yet", { exact: true }).waitFor();
  assert.equal(await student.getByTestId("score").count(), 0);
  assert.equal(await student.getByText("Deviation in numbers").count(), 0);
  assert.equal(await student.getByRole("alert").count(), 0, "waiting is no error");
  assert.equal(await student.getByRole("button", { name: "Try again" }).count(), 0);

  const instructor = await signedIn(world, "instructor", world.attempt("unreleased"));
  await instructor.getByRole("button", { name: "Release score" }).click();
  await instructor.getByText("Score released").waitFor();
  await accessible(instructor, "a released attempt");

  await student.reload();
  await student.getByTestId("score").waitFor();
}

async function markReference(world) {
  const page = await signedIn(world, "instructor", world.attempt("class11"));
  await page.getByRole("button", { name: "Mark as reference…" }).click();
  await page.getByText("Still needed: Dentist who made this cut, The dentist agrees").waitFor();
  await page.getByLabel("Dentist who made this cut").fill("Dentist Two");
  await accessible(page, "naming the dentist");
  const mark = page.getByRole("button", { name: "Mark as reference", exact: true });
  await eventually(async () => assert.equal(await mark.isDisabled(), true, "not without the dentist's consent"));
  await page.getByLabel("The dentist agrees").check();
  await mark.click();
  await page.getByText("Reference of its exercise", { exact: false }).first().waitFor();
  // One that the server refuses, until somebody says why it is right.
  await page.goto(world.attempt("critical"));
  await page.getByRole("button", { name: "Mark as reference…" }).click();
  await page.getByLabel("Dentist who made this cut").fill("Dentist Two");
  await page.getByLabel("The dentist agrees").check();
  await mark.click();
  await page.getByText("cannot be the reference", { exact: false }).waitFor();
  const anyway = page.getByRole("button", { name: "Mark as reference anyway" });
  await eventually(async () => assert.equal(await anyway.isDisabled(), true, "not without a reason"));
  await page.getByLabel("Reason for going ahead").fill("The gap is before the first stroke");
  await accessible(page, "a reason for a reference");
  await world.picture(page, "reference_anyway", { fullPage: true });
  await anyway.click();
  await page.getByText("Reference of its exercise", { exact: false }).first().waitFor();
}

// No station that works loses ticks, so two members of the real answers are changed on their way.
async function disturbedRecording(world) {
  const page = await signedIn(world, "instructor");
  const changed = (address, change) =>
    page.route(address, async (route) => {
      const response = await route.fetch();
      await route.fulfill({ response, json: { ...(await response.json()), ...change } });
    });
  await changed(`**/api/v1${world.attempt("critical")}`, { gap_ticks: 412 });
  await changed(`**/api/v1${world.attempt("critical")}/score`, {
    gap_ticks: 412,
    witness_ok: false,
    witness_note: "the state after chunk 12 differs",
  });
  await page.goto(world.attempt("critical"));
  // The score, which says whether the replay agreed, comes after the attempt itself.
  await page.getByText("does not match the station’s recording", { exact: false }).first().waitFor();
  const text = await page.getByRole("region", { name: "Recording" }).innerText();
  assert.match(text, /Not recorded: 412 ticks/);
  assert.match(text, /does not match the station’s recording: the state after chunk 12 differs/);
}
