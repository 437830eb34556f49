// The attempt's playback and its drawing.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { isTargetLine, toothPixels, toothPixelsBecome } from "./pixels.mjs";
import { accessible, downloaded, looks, signedIn, signIn } from "./session.mjs";

export const playbackFlows = [
  { name: "the tooth is drawn quickly while it moves and in full once it stands", run: drawsQuickly },
  { name: "contact, faults and strokes that lost points stand on the axis of time", run: marksOnTheTime },
  {
    name: "the force on the hand is an arrow at the bur, and what was held back is beside it",
    run: forceArrow,
  },
  { name: "an attempt's tooth is asked for before the page's scripts are there", run: askedAhead },
  { name: "a link's moment is opened once, also without a playback", run: linkIsOpenedOnce },
  { name: "the target is drawn over the tooth, and goes away", run: targetLines },
  { name: "the plot zooms by keys and wheel, and is moved by a drag", run: plotZooms },
  { name: "a short part of the plot is drawn tick by tick", run: tickByTick },
  { name: "while the playback is being made, the picture without one is loaded once", run: stillOnce },
  { name: "the playback is saved as a video, from the beginning to its end", run: video },
  { name: "speed, removed tissues, depth and the pulp are plotted on the same axis", run: secondPlot },
];

async function askedAhead(world) {
  const html = async (path) => (await fetch(new URL(path, world.baseUrl))).text();
  const preloaded = /modulepreload" href="\/assets\/attempt_page-/;
  assert.match(await html(world.attempt("shown")), preloaded);
  assert.doesNotMatch(await html("/attempts"), preloaded, "a list needs no attempt's page");
  const page = await signedIn(world, "instructor", "/attempts");
  await page.route("**/assets/app-*", () => undefined); // which never comes
  const asked = page.waitForRequest("**/timeline");
  await page.goto(world.attempt("shown"), { waitUntil: "commit" });
  await asked;
}

const isArrow = ([r, g, b]) => r > 170 && g > 40 && g < 90 && b < 40;

async function video(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByRole("group", { name: "Playback" }).getByLabel("Speed").selectOption("16");
  const saved = await downloaded(page, async () => {
    await page.getByRole("button", { name: "Save a video" }).click();
    await page.getByText("Recording while it plays…").waitFor();
    await accessible(page, "a video that is recorded");
  });
  assert.match(saved.name, /_video\.webm$/);
  assert.ok(saved.text.startsWith("\u001aE") && saved.text.length > 5000, `${saved.text.length} characters of WebM`);
  const position = page.getByRole("slider", { name: "Playback position" });
  const end = await position.getAttribute("max");
  await eventually(async () => assert.equal(await position.inputValue(), end));
  await page.getByRole("button", { name: "Save a video" }).waitFor();
}

// Chromium draws on the processor here: what moves has fewer pixels until it stands.
async function drawsQuickly(world) {
  const page = await signedIn(world, "student", world.attempt("shown", "?t=30"));
  await page.locator(".tooth-frame canvas[data-drawn=full]").waitFor();
  await page.locator('.playback[data-shown="300"]').waitFor();
  await page.locator(".playback-speed select").selectOption("0.25");
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("k");
  await page.locator(".tooth-frame canvas[data-drawn=quick]").waitFor();
  await page.waitForFunction(() => {
    const canvas = document.querySelector(".tooth-frame canvas");
    return canvas.width < 0.8 * canvas.clientWidth;
  });
  await page.keyboard.press("k");
  await page.waitForFunction(() => {
    const canvas = document.querySelector(".tooth-frame canvas[data-drawn=full]");
    return Math.abs(canvas?.width / canvas?.clientWidth - 1) < 0.01;
  });
  await accessible(page, "a playback that was stopped");
}

// Contact, faults and strokes that lost points, on the axis of slider and plot; keys go from one to
// the next.
async function marksOnTheTime(world) {
  for (const [width, height] of looks([1280, 720], [1440, 900])) {
    const page = await signedIn(world, "instructor", world.attempt("shown", "?t=0"), { width, height });
    await page.locator('.playback[data-shown="0"]').waitFor();
    await page.locator(".spans .span.lost").first().waitFor();
    assert.ok((await page.locator(".spans .span.contact").count()) > 3, "contact was interrupted");
    const [strip, plot] = [
      await page.locator(".spans").boundingBox(),
      await page.locator(".force-card .u-over").boundingBox(),
    ];
    assert.ok(
      Math.abs(strip.x - plot.x) < 2 && Math.abs(strip.x + strip.width - plot.x - plot.width) < 2,
      `at ${width}: the strip is from ${strip.x} to ${strip.x + strip.width}, the plot from ${plot.x} to ${plot.x + plot.width}`,
    );
    assert.ok(plot.y + plot.height <= height, `at ${width}: the plot ends at ${plot.y + plot.height} of ${height}`);
    await page.getByText("Stroke that lost points").waitFor();
    await page.locator("body").click({ position: { x: 5, y: 300 } });
    await page.keyboard.press("x");
    await page.waitForFunction(() => document.querySelector(".playback").dataset.shown !== "0");
    await page.keyboard.press("?");
    assert.match(await page.getByRole("dialog").innerText(), /Next fault, or stroke that lost points/);
    await page.keyboard.press("Escape");
    await accessible(page, `marks on the time at ${width}`);
    await world.picture(page, `marks_${width}`);
  }
}

// Keys and wheel show a part of the time, and slider, marks and plot go along; a double click shows
// all.
async function plotZooms(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown", "?t=20"));
  await page.locator('.playback[data-shown="200"]').waitFor();
  await page.locator(".plot canvas").waitFor();
  const slider = page.getByLabel("Time in the attempt");
  const range = async () => (await slider.evaluate((input) => [input.min, input.max])).map(Number);
  const all = await range();
  const over = page.locator(".force-card .u-over");
  // Not pressed and without Ctrl the wheel is the page's.
  await over.hover();
  await page.mouse.wheel(0, -100);
  assert.deepEqual(await range(), all);
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("i");
  await page.getByText(/^Showing 0:\d\d\.\d to 0:\d\d\.\d\./).waitFor();
  const once = await range();
  assert.ok(once[0] > all[0] && once[1] < all[1], `after a key: ${once}`);
  await over.click();
  await page.mouse.wheel(0, -100);
  await page.waitForFunction(
    (before) =>
      Number(document.querySelector("#timeline").max) - Number(document.querySelector("#timeline").min) < before,
    once[1] - once[0],
  );
  const near = await range();
  const box = await over.boundingBox();
  await page.keyboard.down("Shift");
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 4, box.y + box.height / 2, { steps: 3 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const later = await range();
  assert.ok(
    later[0] > near[0] && Math.abs(later[1] - later[0] - near[1] + near[0]) <= 2,
    `dragged from ${near} to ${later}`,
  );
  await accessible(page, "a part of the time");
  await world.picture(page, "zoomed");
  // The moment takes the part along.
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("Home");
  await page.waitForFunction(
    () => document.querySelector("#timeline").min === "0" && document.querySelector("#timeline").value === "0",
  );
  await over.dblclick();
  await page.getByText(/^Showing /).waitFor({ state: "detached" });
  assert.deepEqual(await range(), all);
  await page.keyboard.press("?");
  await eventually(async () => assert.match(await page.getByRole("dialog").innerText(), /Zoom in on the timeline/));
}

// More plots on the same axis, with the same cursor.
async function secondPlot(world) {
  for (const [width, height] of looks([1280, 720], [1440, 900])) {
    const page = await signedIn(world, "student", world.attempt("shown", "?t=20"), { width, height });
    await page.locator('.playback[data-shown="200"]').waitFor();
    await page.locator(".plot canvas").waitFor();
    await page.locator("body").click({ position: { x: 5, y: 300 } });
    await page.keyboard.press("v");
    const second = page.getByRole("img", { name: /^Also over time: tip speed, enamel removed, dentin removed/i });
    await second.locator("canvas").waitFor();
    await page.locator(".readout").getByText("Dentin removed").waitFor();
    const [one, other] = [
      await page.locator(".force-card .u-over").first().boundingBox(),
      await page.locator(".force-card .u-over").nth(1).boundingBox(),
    ];
    assert.ok(Math.abs(one.x - other.x) < 1 && Math.abs(one.width - other.width) < 1, "both stand on one axis");
    await page.keyboard.press("i");
    const cursors = () =>
      page
        .locator(".plot-cursor")
        .evaluateAll((all) => all.map((each) => Math.round(each.getBoundingClientRect().left)));
    await page.waitForFunction(() => document.querySelector("#timeline").min !== "0");
    await page.locator("#timeline").press("PageUp");
    await page.waitForFunction(
      () =>
        new Set(
          [...document.querySelectorAll(".plot-cursor")].map((each) => Math.round(each.getBoundingClientRect().left)),
        ).size === 1,
    );
    assert.equal((await cursors()).length, 3);
    await page
      .getByRole("img", { name: /^Also over time: tip depth, distance to the pulp/i })
      .locator("canvas")
      .waitFor();
    await page.locator(".readout").getByText("Distance to the pulp").waitFor();
    await accessible(page, `three plots at ${width}`);
    await world.picture(page, `three_plots_${width}`, { fullPage: true });
    await page.getByRole("button", { name: "More over time" }).click();
    await second.waitFor({ state: "detached" });
  }
}

// The force on the hand, where the bur is: an arrow while it touches, none in the air.
async function forceArrow(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown", "?t=20"));
  await page.locator('.playback[data-shown="200"]').waitFor();
  await page.getByText(/^Force on the hand: [\d.]+\sN$/).waitFor();
  await page.waitForFunction(() => document.querySelector(".tooth-force .swatch.force") !== null);
  const touching = await toothPixels(page, isArrow);
  assert.ok(touching > 60, `the arrow has ${touching} pixels`);
  await world.picture(page, "force_arrow");
  await accessible(page, "a force on the tooth");
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("Home");
  await page.locator('.playback[data-shown="0"]').waitFor();
  await page.getByText(/^Force on the hand/).waitFor({ state: "detached" });
  await eventually(async () => assert.equal(await toothPixels(page, isArrow), 0, "no arrow in the air"));
  // What the limiter held back.
  assert.equal(await page.locator(".readout").getByText("Device limit").count(), 0);
  await page.goto(world.attempt("held_back", "?t=20"));
  await page.locator(".readout").getByText("Device limit").waitFor();
  await page.getByText(/^The device’s force limit was reached in [\d\s]+ ticks/).waitFor();
}

// What the exercise asks for, and how far beside it may be cut, as lines over the tooth.
async function targetLines(world) {
  const page = await signedIn(world, "student", world.attempt("shown", "?t=20"));
  await page.locator('.playback[data-shown="200"]').waitFor();
  const before = await toothPixels(page, isTargetLine);
  const button = page.getByRole("button", { name: "Target", exact: true });
  await button.click();
  await toothPixelsBecome(page, "lines of the target", isTargetLine, (count) => count > before + 150);
  await eventually(async () => assert.equal(await button.getAttribute("aria-pressed"), "true"));
  await world.picture(page, "target_lines");
  await accessible(page, "the target over the tooth");
  await page.keyboard.press("g");
  await toothPixelsBecome(page, "no lines", isTargetLine, (count) => count <= before + 20);
}

// A few seconds are shown tick by tick, from the recording; panning asks for no more than it shows.
async function tickByTick(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown", "?t=20"));
  const asked = [];
  page.on("request", (request) => {
    if (request.url().includes("/ticks?")) asked.push(new URL(request.url()).search);
  });
  await page.locator('.playback[data-shown="200"]').waitFor();
  await page.locator(".plot canvas").waitFor();
  assert.deepEqual(asked, [], "all of it needs no ticks");
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  for (let i = 0; i < 12; ++i) await page.keyboard.press("i");
  await page.getByText(/^Showing 0:(19|20)\.\d\d to 0:20\.\d\d, tick by tick\./).waitFor();
  await page
    .getByRole("img", { name: /tick by tick\.$/ })
    .locator("canvas")
    .waitFor();
  const ends = async () =>
    (await page.locator(".view-of").innerText()).match(/0:(\d\d\.\d\d)/g).map((text) => Number(text.slice(2)));
  const [from, to] = await ends();
  assert.ok(to - from < 0.5, `${from} to ${to}`);
  for (const search of asked) {
    const query = new URLSearchParams(search);
    assert.ok(Number(query.get("to")) - Number(query.get("from")) <= 4000, search);
  }
  // A drag with Shift moves the part.
  const over = page.locator(".force-card .u-over");
  const box = await over.boundingBox();
  const before = asked.length;
  await page.keyboard.down("Shift");
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 4, box.y + box.height / 2, { steps: 8 });
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const moved = await ends();
  assert.ok(Math.abs(moved[0] - from - (to - from) / 4) < 0.03, `dragged from ${from} to ${moved[0]}`);
  assert.ok(asked.length - before <= 1, "what was there is not asked for again");
  await accessible(page, "a plot tick by tick");
  await world.picture(page, "ticks");
  await over.dblclick();
  await page.getByText(/^Showing /).waitFor({ state: "detached" });
}

// A link's moment is opened once, also where the playback fails after the plots are there. Data
// that is loaded again later does not undo a person's choice.
async function linkIsOpenedOnce(world) {
  const page = await world.open();
  const asked = [];
  await page.route("**/timeline", (route) => {
    asked.push(route);
  });
  const fail = () =>
    asked.splice(0).map((route) =>
      route.fulfill({
        status: 404,
        json: { error: { code: "not_found", message: "There is no timeline.", field: "" } },
      }),
    );
  await page.goto(world.attempt("unreleased", "?t=20"));
  await signIn(page, world.logins.instructor);
  const slider = page.getByLabel("Time in the attempt");
  await page.locator(".plot canvas").waitFor();
  await page.waitForFunction(() => {
    const { value, max } = document.querySelector("#timeline");
    return Number(value) > 0 && value !== max;
  });
  fail();
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await slider.fill("500");
  // Somebody had it scored again meanwhile, with another result.
  await page.route(`**/api/v1${world.attempt("unreleased")}`, async (route) => {
    const response = await route.fetch();
    const row = await response.json();
    await route.fulfill({ response, json: { ...row, computed_score: row.computed_score - 1 } });
  });
  const again = page.waitForRequest("**/timeline");
  await page.getByRole("button", { name: "Release score" }).click();
  await page.getByText("Score released").waitFor();
  await again;
  await page.locator(".plot canvas").waitFor();
  await eventually(async () => assert.equal(await slider.inputValue(), "500"));
  fail();
}

// The picture has megabytes. It comes more slowly than the playback is asked for again.
async function stillOnce(world) {
  const page = await world.open();
  const surfaces = [];
  let made = false;
  await page.route("**/timeline", (route) =>
    made
      ? route.continue()
      : route.fulfill({
          status: 503,
          json: { error: { code: "unavailable", message: "The playback is being made.", field: "" } },
        }),
  );
  await page.route("**/surface", (route) => {
    surfaces.push(route);
  });
  await page.goto(world.attempt("shown"));
  await signIn(page, world.logins.instructor);
  await eventually(async () => assert.equal(surfaces.length, 1));
  await page.waitForResponse("**/timeline");
  await surfaces[0].continue();
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  assert.equal(surfaces.length, 1, "the picture is not asked for again");
  made = true;
  await page.locator(".playback[data-shown]").waitFor();
  assert.equal(surfaces.length, 1);
}
