// What a person does with the page, as checks. Every flow runs against the mock server; those marked
// `anywhere` also against a real one whose newest scored attempt, not itself the reference, deviates
// from its reference by about 0.3 mm somewhere, as the demonstration's does.
import assert from "node:assert/strict";
import { openPage } from "./browser.mjs";
import { countColors } from "./pixels.mjs";
import { decodePng } from "./png.mjs";
import { adminFlows } from "./admin_flows.mjs";
import { screenFlow } from "./screens.mjs";
import { accessible, signedIn, signIn } from "./session.mjs";
import { insightFlows } from "./insight_flows.mjs";
import { playbackFlows } from "./playback_flows.mjs";
import { teachingFlows } from "./teaching_flows.mjs";

const kScored = "✓ Scored";

export const flows = [
  { name: "the page speaks German and Chinese from the sign-in on, and who chose one finds it again", anywhere: false, run: speaksLanguages },
  { name: "a wrong password is refused in words and keeps the login", anywhere: true, run: wrongPassword },
  { name: "an expired session asks to sign in again and leads back", anywhere: true, run: expiredSession },
  { name: "a student finds exercises, what is asked, and own attempts only", anywhere: true, run: studentLooksAround },
  { name: "somebody else's attempt is as if it did not exist", anywhere: true, run: foreignAttempt },
  { name: "an instructor sees score, deviation on the tooth, and forces", anywhere: true, run: instructorReviews },
  { name: "the tooth turns by keyboard and the timeline moves the tool", anywhere: true, run: toothByKeyboard },
  { name: "an attempt is played back with the tooth being cut", anywhere: false, run: playsBack },
  { name: "the page fits a narrow screen and a dark scheme without an accessibility violation", anywhere: true, run: narrowAndDark },
  { name: "an admin reads people, stations, devices, jobs and audit", anywhere: true, run: adminReads },
  { name: "a score that is being computed shows progress and then appears", anywhere: false, run: scoringProgress },
  { name: "an instructor releases a graded score and the student then sees it", anywhere: false, run: release },
  { name: "a lost point leads to its moment", anywhere: false, run: lostPointLeadsToItsMoment },
  { name: "a pointer over the plot leaves the moment where it is, a press sets it", anywhere: false, run: plotPointer },
  { name: "slider, plot and remarks share one axis of time", anywhere: false, run: oneTimeAxis },
  { name: "a link opens the same moment from the same side", anywhere: false, run: momentLink },
  { name: "tooth, timeline and plot are seen together without scrolling", anywhere: false, run: oneViewport },
  { name: "an attempt is played back by keys, wherever the focus is", anywhere: false, run: playbackKeys },
  { name: "an address with a moment beyond the end shows the end and says so", anywhere: false, run: momentBeyondTheEnd },
  { name: "two attempts are looked at side by side", anywhere: false, run: beside },
  { name: "two attempts fit a small window, with nothing over the teeth", anywhere: false, run: besideInASmallWindow },
  { name: "a tooth is cut open along four planes", anywhere: false, run: section },
  { name: "an instructor marks an attempt as the reference", anywhere: false, run: markReference },
  { name: "gaps and a replay that disagrees are said plainly", anywhere: false, run: disturbedRecording },
  ...["student", "instructor", "admin"].map((role) => ({
    name: `every screen of the ${role} is accessible and fits wide and narrow`, anywhere: false, run: screenFlow(role) })),
  ...adminFlows.map((flow) => ({ ...flow, anywhere: false })),
  ...[...teachingFlows, ...insightFlows, ...playbackFlows].map((flow) => ({ ...flow, anywhere: false })),
  { name: "the mock server refuses what its contract does not allow, and answers nothing else", anywhere: false, run: contractIsKept },
  { name: "more attempts than one page are loaded on request", anywhere: false, run: pagination },
];

async function wrongPassword(world) {
  const { page } = await world.open();
  await page.goto("/");
  await signIn(page, { login: world.logins.student.login, password: "not this one" });
  const alert = page.getByRole("alert");
  await alert.waitFor();
  assert.match(await alert.innerText(), /Login and password do not belong together/);
  assert.equal(await page.getByLabel("Login").inputValue(), world.logins.student.login);
  await accessible(page, "sign-in with an error");
  await signIn(page, world.logins.student);
  await page.getByRole("heading", { level: 1, name: "My work" }).waitFor();
}

async function expiredSession(world) {
  const page = await signedIn(world, "student", "/attempts");
  await page.getByRole("heading", { level: 1, name: "My attempts" }).waitFor();
  await page.locator("table").waitFor();
  // A request still under way when the cookies go would end the session before the click does.
  await page.waitForLoadState("networkidle");
  await page.context().clearCookies();
  await page.getByRole("link", { name: "Exercises" }).click();
  await page.getByText("Your session has ended").waitFor();
  assert.equal(new URL(page.url()).pathname, "/exercises");
  await signIn(page, world.logins.student);
  await page.getByRole("heading", { level: 1, name: "Exercises" }).waitFor();
}

async function studentLooksAround(world) {
  const page = await signedIn(world, "student");
  await page.getByRole("heading", { level: 1, name: "My work" }).waitFor();
  await page.getByRole("link", { name: "Exercises", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Exercises" }).waitFor();
  await page.locator("main article").first().waitFor();
  await accessible(page, "exercises");
  await page.locator("main article a").first().click();
  await page.getByRole("heading", { level: 2, name: "What is asked" }).waitFor();
  assert.match(await page.getByRole("main").innerText(), /Depth\s+[\d.]+\smm/);
  await accessible(page, "an exercise");
  await page.getByRole("link", { name: "My attempts" }).click();
  await page.getByRole("heading", { level: 1, name: "My attempts" }).waitFor();
  await page.locator("table").waitFor();
  assert.equal(await page.getByRole("columnheader", { name: "Student" }).count(), 0);
  await accessible(page, "own attempts");
}

async function foreignAttempt(world) {
  const page = await signedIn(world, "student", `/attempts/${world.foreignAttempt}`);
  await page.getByRole("heading", { level: 1, name: "Attempt" }).waitFor();
  assert.match(await page.getByRole("alert").innerText(), /There is no such attempt for you/);
  await accessible(page, "a missing attempt");
}

// The first scored attempt of a student that is not the reference itself.
async function openScoredAttempt(world, options = {}) {
  const page = await signedIn(world, "instructor", "/attempts", options);
  const row = page.locator("tbody tr").filter({ hasText: kScored }).filter({ hasNotText: "Reference" }).filter({ hasNotText: "Gaps" }).first();
  await row.getByRole("link").click();
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".plot canvas").waitFor();
  return page;
}

async function instructorReviews(world) {
  const page = await openScoredAttempt(world);
  const score = Number.parseFloat(await page.getByTestId("score").innerText());
  assert.ok(score > 0 && score <= 100, `score ${score}`);
  const lost = await page.locator(".criteria tbody tr").evaluateAll((rows) => rows.map((row) => {
    const [points, of] = row.querySelector(".points").innerText.split("/").map(Number.parseFloat);
    return of - points;
  }));
  assert.ok(lost.length >= 3);
  assert.deepEqual(lost, [...lost].sort((a, b) => b - a), "criteria that lost most come first");
  await accessible(page, "an attempt");
  await page.screenshot({ path: world.picture("attempt"), fullPage: true });
  await heatMapIsThere(page);
  await plotIsThere(page);
}

// A lost point has a line with its moment; a click puts timeline and tooth there.
async function lostPointLeadsToItsMoment(world) {
  const page = await openScoredAttempt(world);
  const slider = page.getByRole("slider", { name: /moment|time/i }).first();
  const before = await slider.inputValue();
  await page.getByRole("button", { name: /too much, first at 0:21.4; mostly stroke 7 and 2 more/ }).click();
  assert.notEqual(await slider.inputValue(), before, "the timeline moves");
  await page.getByRole("heading", { name: "Among 3 dentists" }).waitFor();
  await page.getByText(/Nearest is the cut of Dentist One/).waitFor();
  await accessible(page, "an attempt among dentists");
  await page.screenshot({ path: world.picture("lost_point"), fullPage: true });
}

async function plotPointer(world) {
  const page = await openScoredAttempt(world);
  const slider = page.getByLabel("Time in the attempt");
  await page.locator(".force-card .u-over").scrollIntoViewIfNeeded();
  const box = await page.locator(".force-card .u-over").boundingBox();
  await page.mouse.move(box.x + 0.2 * box.width, box.y + box.height / 2);
  await page.mouse.move(box.x + 0.7 * box.width, box.y + box.height / 2, { steps: 5 });
  await page.locator(".plot-hover").waitFor();
  assert.equal(await slider.inputValue(), await slider.getAttribute("max"), "passing over it is no choice: it stays at the end");
  await page.mouse.down();
  await page.mouse.up();
  const set = Number(await slider.inputValue());
  assert.ok(Math.abs(set / Number(await slider.getAttribute("max")) - 0.7) < 0.01, `step ${set}`);
  await page.mouse.move(box.x + 0.1 * box.width, box.y + box.height / 2, { steps: 5 });
  assert.equal(Number(await slider.inputValue()), set);
}

// Where the plot draws a moment, there its mark stands and there is the slider's thumb.
async function oneTimeAxis(world) {
  for (const [width, height] of [[1440, 900], [390, 844]]) {
    const page = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000105", { width, height });
    await page.locator(".plot canvas").waitFor();
    const slider = page.getByLabel("Time in the attempt");
    const centre = ({ x, width: wide }) => x + wide / 2;
    for (const mark of await page.getByRole("group", { name: "Remarks along the time" }).getByRole("button").all()) {
      await mark.click();
      const at = centre(await page.locator(".plot-cursor").boundingBox());
      const thumb = (await slider.boundingBox()).x + thumbIn(await slider.screenshot());
      assert.ok(Math.abs(centre(await mark.boundingBox()) - at) < 2, `at ${width}: the mark is at ${centre(await mark.boundingBox())}, the plot's cursor at ${at}`);
      assert.ok(Math.abs(thumb - at) < 2, `at ${width}: the slider's thumb is at ${thumb}, the plot's cursor at ${at}`);
    }
  }
}

async function momentLink(world) {
  const path = "/attempts/00000000-0000-7000-8000-000000000105";
  const page = await signedIn(world, "instructor", path);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".playback").waitFor();
  await page.getByLabel("Time in the attempt").fill("700");
  await page.getByRole("button", { name: "Buccal", exact: true }).click();
  await page.locator('.playback[data-shown="168"]').waitFor();
  // Before the address takes a row of its own, which moves the picture by a fraction of a pixel.
  const before = await page.locator(".tooth-frame canvas").screenshot();
  await page.getByRole("button", { name: "Link to this moment" }).click();
  const link = await page.locator(".moment-link code").innerText();
  assert.match(link, /\?t=16\.8&view=-?[\d.]+_[\d.]+_[\d.]+_0$/);
  await page.goto(link);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.waitForFunction(() => document.querySelector("#timeline")?.value === "700");
  await page.locator('.playback[data-shown="168"]').waitFor();
  // The address has four decimals: edges may fall a pixel aside.
  const apart = differing(before, await page.locator(".tooth-frame canvas").screenshot());
  assert.ok(apart < 0.02, `${apart} of the picture differs`);
  await page.getByRole("button", { name: "Mesial", exact: true }).click();
  assert.ok(differing(before, await page.locator(".tooth-frame canvas").screenshot()) > 0.05, "another side is another picture");
}

// Of the mock's attempt of 43.2 seconds, in frames of a tenth.
async function playbackKeys(world) {
  const page = await signedIn(world, "student", "/attempts/00000000-0000-7000-8000-000000000105?t=30");
  const at = (frames) => page.locator(`.playback[data-shown="${frames}"]`).waitFor();
  await at(300);
  await page.locator(".playback-time", { hasText: "0:30.0" }).waitFor();
  await page.keyboard.press(".");
  await at(301);
  await page.keyboard.press("j");
  await at(251);
  await page.keyboard.press("End");
  await at(432);
  await page.keyboard.press("Home");
  await at(0);
  // On a button, on the tooth and on a choice they act as well; there the arrows are the tooth's and the choice's own.
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
  await page.getByText("Played again from 0:14.9 to 0:19.9").waitFor({ state: "attached" });
  await page.getByText("Figures of 0:14.9 to 0:19.9").click();
  await page.getByRole("columnheader", { name: "95 % below" }).waitFor();
  const saved = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save this part as CSV" }).click();
  assert.match((await saved).suggestedFilename(), /^attempt_0_14\.9_to_0_19\.9\.csv$/);
  await accessible(page, "a loop");
  await page.screenshot({ path: world.picture("loop") });
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
  for (const what of ["Play and pause", "5 seconds back", "One frame on", "Play again from here (A)", "Faster", "To the end"]) assert.ok(help.includes(what), what);
  await accessible(page, "the list of keys");
  // In a text they are letters.
  const teacher = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000105?t=20");
  await teacher.locator('.playback[data-shown="200"]').waitFor();
  await teacher.getByLabel(/New remark/).pressSequentially("jkl. [");
  assert.equal(await teacher.getByLabel(/New remark/).inputValue(), "jkl. [");
  assert.equal(await teacher.locator(".playback").getAttribute("data-shown"), "200");
}

async function momentBeyondTheEnd(world) {
  const page = await signedIn(world, "student", "/attempts/00000000-0000-7000-8000-000000000105?t=90");
  await page.getByText("The address names 1:30.0, but the attempt ends at 0:43.2: its end is shown.").waitFor();
  await page.locator('.playback[data-shown="432"]').waitFor();
  await accessible(page, "a moment beyond the end");
}

async function section(world) {
  const page = await signedIn(world, "student", "/attempts/00000000-0000-7000-8000-000000000105");
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByRole("button", { name: "Cavity", exact: true }).click();
  // What moves is drawn in a lighter way, and in full once it rests.
  const picture = async () => {
    await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
    await page.locator(".tooth-frame canvas[data-drawn=full]").waitFor();
    return page.locator(".tooth-frame canvas").screenshot();
  };
  const whole = await picture();
  for (const [across, name] of [["y", "mesio-distal"], ["x", "bucco-lingual"], ["z", "horizontal"], ["view", "along"]]) {
    await page.getByLabel("Section", { exact: true }).selectOption(across);
    const cut = await picture();
    assert.ok(differing(whole, cut) > 0.02, `the ${name} section shows`);
    await page.getByLabel("Place of the section").fill("25");
    assert.ok(differing(cut, await picture()) > 0.005, `the ${name} section moves`);
    await page.screenshot({ path: world.picture(`section_${across}`) });
  }
  await page.getByRole("button", { name: "Other side" }).click();
  await accessible(page, "a section");
  await page.getByLabel("Section", { exact: true }).selectOption("");
  assert.ok(differing(whole, await picture()) < 0.01, "and it is whole again");
}

async function beside(world) {
  const page = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000105?t=30");
  await page.locator('.playback[data-shown="300"]').waitFor();
  const choice = page.getByLabel("Compare with");
  await choice.focus();
  await choice.locator("optgroup[label='By others'] option").first().waitFor({ state: "attached" });
  await choice.selectOption({ label: await choice.locator("optgroup[label='By others'] option").first().textContent() });
  await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".other-time", { hasText: "0:30.0" }).waitFor();
  await page.getByRole("button", { name: "Occlusal", exact: true }).click();
  // Both are the mock's one attempt: from the same side, at the same moment they look alike.
  await page.getByLabel("The other’s moment").selectOption("removed");
  await page.locator(".other-time", { hasText: /0:(29|30)\.\d/ }).waitFor();
  await accessible(page, "two attempts");
  await page.screenshot({ path: world.picture("beside") });
  await choice.selectOption("");
  await page.locator(".other-tooth").waitFor({ state: "detached" });
}

// Of the visible ones, in the window's pixels.
async function boxesOf(page, selector) {
  return page.locator(selector).evaluateAll((found) => found.map((element) => element.getBoundingClientRect()).filter((box) => box.width > 1).map((box) => box.toJSON()));
}

const kTools = ".tooth-tools .button, .tooth-tools select, .tooth-tools [type=range], .tooth-tools .segmented label";

// What there is to choose lies beside the teeth, inside the card, none of it over another, and the plot's axis is in view.
async function fitsBesideTheTeeth(page, height, where) {
  const [teeth, tools, [card], [plot]] = [await boxesOf(page, ".tooth-frame"), await boxesOf(page, kTools), await boxesOf(page, ".tooth-card"), await boxesOf(page, ".force-card .plot canvas")];
  const apart = (a, b) => a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
  assert.ok(tools.length > 10, `${where}: ${tools.length} tools`);
  for (const [i, tool] of tools.entries()) {
    const text = `${where}: a tool from ${tool.left}, ${tool.top} to ${tool.right}, ${tool.bottom}`;
    for (const tooth of teeth) assert.ok(apart(tool, tooth), `${text} over a tooth`);
    for (const other of tools.slice(i + 1)) assert.ok(apart(tool, other), `${text} over another, from ${other.left}, ${other.top}`);
    assert.ok(tool.left >= card.left && tool.right <= card.right && tool.height >= 18, `${text} beyond the card, or too low`);
  }
  for (const tooth of teeth) assert.ok(tooth.width >= 200 && tooth.height >= 180, `${where}: a tooth of ${tooth.width} x ${tooth.height}`);
  assert.ok(plot.bottom <= height + 1, `${where}: the plot ends at ${plot.bottom} of ${height}`);
}

async function besideInASmallWindow(world) {
  for (const [width, height, colorScheme, languages] of [[1280, 720, "light", ["en", "de", "zh"]], [1280, 720, "dark", ["en"]], [1440, 900, "light", ["en"]]]) {
    const page = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000105", { width, height, colorScheme });
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    for (const language of languages) {
      if (language !== "en") {
        await page.goto("/account");
        await page.locator("main select").selectOption(language);
        await page.locator(`html[lang^=${language}]`).waitFor();
        await page.goto("/attempts/00000000-0000-7000-8000-000000000105");
        await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
      }
      const choice = page.locator(".tooth-choices select").last();
      await choice.focus();
      await choice.locator("optgroup option").first().waitFor({ state: "attached" });
      await choice.selectOption({ label: await choice.locator("optgroup option").first().textContent() });
      await page.locator(".other-tooth .tooth-frame[aria-busy=false] canvas").waitFor();
      const where = `${language} ${colorScheme} at ${width} x ${height}`;
      await fitsBesideTheTeeth(page, height, `${where}, side by side`);
      await page.screenshot({ path: world.picture(`beside_${language}_${width}_${colorScheme}`) });
      await page.locator(".tooth-choices select").first().selectOption("x");
      await fitsBesideTheTeeth(page, height, `${where}, cut open`);
      await page.locator(".compare-bar input[value=top]").check({ force: true });
      await page.locator(".other-tooth").waitFor({ state: "detached" });
      await fitsBesideTheTeeth(page, height, `${where}, on top`);
    }
    if (languages.length > 1) {
      await page.goto("/account");
      await page.locator("main select").selectOption("en");
      await page.locator("html[lang=en]").waitFor();
    }
  }
}

// The share of pixels that differ clearly.
function differing(one, other) {
  const [a, b] = [decodePng(one), decodePng(other)];
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  let count = 0;
  for (let y = 0; y < a.height; ++y) {
    for (let x = 0; x < a.width; ++x) if (a.at(x, y).some((value, i) => Math.abs(value - b.at(x, y)[i]) > 12)) ++count;
  }
  return count / (a.width * a.height);
}

async function oneViewport(world) {
  for (const [width, height] of [[1440, 900], [1280, 720]]) {
    const page = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000105", { width, height });
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    await page.locator(".plot canvas").waitFor();
    for (const part of [".tooth-frame", "#timeline", ".marks", ".force-card .u-over"]) {
      const box = await page.locator(part).boundingBox();
      assert.ok(box.y >= 0 && box.y + box.height <= height, `${part} ends at ${box.y + box.height} of ${height}`);
    }
    assert.ok((await page.locator(".tooth-frame").boundingBox()).height >= 200);
    // What is said of them scrolls by; they stay.
    await page.mouse.move(200, height / 2);
    await page.mouse.wheel(0, 250);
    await page.waitForFunction(() => window.scrollY > 100);
    await page.getByRole("button", { name: /too much, first at/ }).click();
    const tooth = await page.locator(".tooth-frame").boundingBox();
    assert.ok(tooth.y >= 0 && tooth.y + tooth.height <= height, "the tooth is in view");
    await page.screenshot({ path: world.picture(`one_viewport_${width}`) });
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

// Ivory (as the reference), red (0.3 mm too far) and the neutral of untouched tooth, in view at once.
async function heatMapIsThere(page) {
  const counts = await countColors(page, ".tooth-frame canvas", {
    deep: ([r, g, b]) => r > 130 && r > 1.6 * g && r > 1.8 * b,
    asReference: ([r, g, b]) => r > 150 && r - b > 5 && r - b < 45 && Math.abs(r - g) < 20,
    untouched: ([r, g, b]) => r > 60 && r < 230 && b > r && b - r < 30 && Math.abs(r - g) < 16,
  });
  assert.ok(counts.deep > 300, `too far: ${counts.deep} pixels`);
  assert.ok(counts.asReference > 300, `as the reference: ${counts.asReference} pixels`);
  assert.ok(counts.untouched > 5000, `untouched: ${counts.untouched} pixels`);
  await page.getByLabel("Tissues").check();
  const tissues = await countColors(page, ".tooth-frame canvas", { deep: ([r, g, b]) => r > 130 && r > 1.9 * g && r > 1.9 * b });
  assert.ok(tissues.deep < counts.deep / 4, "tissue colours replace the deviation's");
  await page.getByLabel("Deviation").check();
}

async function plotIsThere(page) {
  const counts = await countColors(page, ".plot canvas", { force: ([r, g, b]) => b > 90 && b > 1.4 * r && g > r, removed: ([r, g, b]) => r > 150 && r > 1.5 * b && g < r });
  assert.ok(counts.force > 300 && counts.removed > 100, `plot: ${JSON.stringify(counts)}`);
}

async function toothByKeyboard(world) {
  const page = await openScoredAttempt(world);
  const canvas = page.locator(".tooth-frame canvas");
  const before = await canvas.screenshot();
  await page.locator(".tooth-frame").focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press("ArrowRight");
  const turned = await canvas.screenshot();
  assert.ok(!turned.equals(before), "arrow keys turn the tooth");
  await page.getByRole("button", { name: "Occlusal" }).click();
  const occlusal = await canvas.screenshot();
  assert.ok(!occlusal.equals(turned), "a preset moves the camera");

  const timeline = page.getByLabel("Time in the attempt");
  await timeline.focus();
  await page.keyboard.press("Home");              // it opens at the end
  for (let i = 0; i < 4; ++i) await page.keyboard.press("PageUp");
  assert.ok(Number(await timeline.inputValue()) > 0);
  assert.match(await timeline.getAttribute("aria-valuetext"), /^\d+:\d\d\.\d, .*largest force.*\sN/i);
  assert.ok(!(await canvas.screenshot()).equals(occlusal), "the tool appears at the tooth");

  await page.getByText("The same as a table").click();
  assert.ok(await page.getByRole("group", { name: "Force and removal as a table" }).locator("tbody tr").count() > 10);
  await page.getByText("Deviation in numbers").click();
  await page.getByText("Of the surface that was cut", { exact: false }).first().waitFor();
  assert.match(await page.getByRole("main").innerText(), /Of the surface that was cut, \d+ % lies within 0\.\d+\smm of the reference/);
  await accessible(page, "an attempt with its tables open");
}

async function playsBack(world) {
  const page = await openScoredAttempt(world);
  const canvas = page.locator(".tooth-frame canvas");
  const bar = page.getByRole("group", { name: "Playback" });
  const position = bar.getByRole("slider", { name: "Playback position" });
  await position.waitFor();
  const last = await position.getAttribute("max");
  assert.equal(await position.inputValue(), last, "it begins with the tooth at the end");
  const end = await canvas.screenshot();
  await position.fill("0");
  await page.waitForFunction(() => document.querySelector(".playback-time").innerText === "0:00.0");
  await page.locator('.playback[data-shown="0"]').waitFor();
  const start = await canvas.screenshot();
  assert.ok(!start.equals(end), "the tooth is the one before");
  await bar.getByRole("button", { name: "One frame on" }).click();
  await page.waitForFunction(() => document.querySelector(".playback-time").innerText === "0:00.1");
  await position.fill("300");
  await page.locator('.playback[data-shown="300"]').waitFor();
  assert.ok(!(await canvas.screenshot()).equals(start), "something is cut and the bur is elsewhere");
  await page.screenshot({ path: world.picture("playback"), fullPage: true });
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
  await page.waitForFunction(() => document.querySelector(".playback input").value === "382");
}

async function narrowAndDark(world) {
  const page = await openScoredAttempt(world, { width: 390, height: 844, colorScheme: "dark" });
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.ok(overflow <= 0, `the page is ${overflow} px wider than the screen`);
  await page.screenshot({ path: world.picture("attempt_narrow_dark"), fullPage: true });
  await accessible(page, "an attempt, narrow and dark");
}

async function adminReads(world) {
  const page = await signedIn(world, "admin");
  for (const [link, title] of [["People", "People"], ["Stations", "Stations"], ["Devices", "Device profiles"], ["Jobs", "Jobs"], ["Audit", "Audit"]]) {
    await page.getByRole("link", { name: link, exact: true }).click();
    await page.getByRole("heading", { level: 1, name: title }).waitFor();
    await page.locator("main table").first().waitFor();
    await accessible(page, title);
  }
}

async function scoringProgress(world) {
  const page = await signedIn(world, "instructor", "/attempts");
  await page.locator("tbody tr").filter({ hasText: "Being scored" }).getByRole("link").click();
  await page.getByRole("progressbar", { name: "Replaying and scoring" }).waitFor();
  await page.getByTestId("score").waitFor();
}

async function release(world) {
  const student = await signedIn(world, "student", "/attempts/00000000-0000-7000-8000-000000000106");
  await student.getByText("Not released yet", { exact: true }).waitFor();
  assert.equal(await student.getByTestId("score").count(), 0);
  assert.equal(await student.getByText("Deviation in numbers").count(), 0);
  assert.equal(await student.getByRole("alert").count(), 0, "waiting is no error");
  assert.equal(await student.getByRole("button", { name: "Try again" }).count(), 0);

  const instructor = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000106");
  await instructor.getByRole("button", { name: "Release score" }).click();
  await instructor.getByText("Score released").waitFor();
  await accessible(instructor, "a released attempt");

  await student.reload();
  await student.getByTestId("score").waitFor();
}

// What a school wrote stays as it is.
async function builtInExercisesAreTranslated(page) {
  await page.goto("/exercises");
  await page.getByRole("heading", { name: "Klasse-II-Kavität, mesialer Kasten" }).waitFor();
  await page.getByText("Den mesialen Kasten präparieren: 3,2 mm breit, 3,5 mm tief ab der Randleiste", { exact: false }).waitFor();
  await page.getByRole("heading", { name: "Occlusal cavity, class I" }).waitFor();
  await page.getByText("Keep the walls upright and the floor flat.", { exact: false }).waitFor();
}

async function speaksLanguages(world) {
  const { page } = await world.open();
  const { login, password } = world.logins.student;
  await page.goto("/attempts/00000000-0000-7000-8000-000000000120");
  await page.getByRole("button", { name: "Deutsch" }).click();
  await page.getByRole("heading", { name: "Anmelden" }).waitFor();
  assert.equal(await page.locator("html").getAttribute("lang"), "de");
  await accessible(page, "the sign-in in German");
  await page.screenshot({ path: world.picture("sign_in_de") });
  await page.getByLabel("Anmeldename").fill(login);
  await page.getByLabel("Passwort").fill("not it");
  await page.getByRole("button", { name: "Anmelden", exact: true }).click();
  await page.getByText("passen nicht zusammen", { exact: false }).waitFor();
  await page.getByLabel("Passwort").fill(password);
  await page.getByRole("button", { name: "Anmelden", exact: true }).click();
  await page.getByTestId("score").waitFor();
  assert.match(await page.locator(".score-card").innerText(), /von 100[^]*Verglichen mit dem Schnitt von/);
  await page.getByText("Abweichung in Zahlen").waitFor();
  // Of a real server it is not known which exercises it has.
  if (world.mock !== undefined) await builtInExercisesAreTranslated(page);
  // It is kept with the person: another browser, set to English, speaks it after signing in.
  const { page: other } = await world.open();
  await other.goto("/account");
  await signIn(other, world.logins.student);
  await other.getByRole("button", { name: "Abmelden" }).waitFor();
  await other.getByLabel("Sprache dieser Seite").selectOption("zh");
  await other.getByRole("button", { name: "退出登录" }).waitFor();
  assert.equal(await other.locator("html").getAttribute("lang"), "zh-Hans");
  await other.goto("/attempts/00000000-0000-7000-8000-000000000120");
  await other.getByTestId("score").waitFor();
  await other.screenshot({ path: world.picture("result_zh"), fullPage: true });
  const teacher = (await world.open()).page;
  await teacher.goto("/grading?assignment=00000000-0000-7000-8000-000000000500");
  await teacher.getByRole("button", { name: "中文" }).click();
  await teacher.getByLabel("用户名").fill(world.logins.instructor.login);
  await teacher.getByLabel("密码").fill(world.logins.instructor.password);
  await teacher.getByRole("button", { name: "登录", exact: true }).click();
  await teacher.getByRole("button", { name: "从第一个开始" }).waitFor();
  await teacher.screenshot({ path: world.picture("grading_zh"), fullPage: true });
  await teacher.goto("/assignments/00000000-0000-7000-8000-000000000500");
  await teacher.locator(".insight .tenths").first().waitFor();
  assert.match(await teacher.locator(".insight").innerText(), /近中壁/, "titles of built-in criteria");
  await teacher.goto("/live");
  await teacher.locator(".live-card .badge.good").first().waitFor();
  assert.match(await teacher.locator("main").innerText(), /当前力/);
}

async function markReference(world) {
  const page = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000106");
  await page.getByRole("button", { name: "Mark as reference…" }).click();
  await page.getByLabel("Dentist who made this cut").fill("Dentist Two");
  await accessible(page, "naming the dentist");
  const mark = page.getByRole("button", { name: "Mark as reference", exact: true });
  assert.equal(await mark.isDisabled(), true, "not without the dentist's consent");
  await page.getByLabel("The dentist agrees").check();
  await mark.click();
  await page.getByText("Reference of its exercise", { exact: false }).first().waitFor();
  // One that the server refuses, until somebody says why it is right.
  await page.goto("/attempts/00000000-0000-7000-8000-000000000104");
  await page.getByRole("button", { name: "Mark as reference…" }).click();
  await page.getByLabel("Dentist who made this cut").fill("Dentist Two");
  await page.getByLabel("The dentist agrees").check();
  await mark.click();
  await page.getByText("cannot be what others are compared with", { exact: false }).waitFor();
  const anyway = page.getByRole("button", { name: "Mark as reference all the same" });
  assert.equal(await anyway.isDisabled(), true, "not without a reason");
  await page.getByLabel("Why all the same").fill("The gap is before the first stroke");
  await accessible(page, "a reason for a reference");
  await page.screenshot({ path: world.picture("reference_anyway"), fullPage: true });
  await anyway.click();
  await page.getByText("Reference of its exercise", { exact: false }).first().waitFor();
}

async function disturbedRecording(world) {
  const page = await signedIn(world, "instructor", "/attempts/00000000-0000-7000-8000-000000000104");
  // The score, which says whether the replay agreed, comes after the attempt itself.
  await page.getByText("does not repeat what the station recorded", { exact: false }).first().waitFor();
  const text = await page.getByRole("region", { name: "Recording" }).innerText();
  assert.match(text, /412 ticks .* were not recorded/);
  assert.match(text, /does not repeat what the station recorded: the state after chunk 12 differs/);
}

async function pagination(world) {
  const page = await signedIn(world, "instructor", "/attempts");
  await page.locator("tbody tr").first().waitFor();
  const before = await page.locator("tbody tr").count();
  await page.getByRole("button", { name: "Show more" }).click();
  await page.waitForFunction((count) => document.querySelectorAll("tbody tr").length > count, before);
  assert.equal(await page.getByRole("button", { name: "Show more" }).count(), 0);
}

async function contractIsKept({ baseUrl, mock, broken, logins }) {
  const ask = (path, method = "GET", body = undefined, headers = {}) =>
    fetch(`${baseUrl}/api/v1${path}`, { method, headers: { "Content-Type": "application/json", ...headers }, body: body && JSON.stringify(body) });
  const status = async (...asked) => (await ask(...asked)).status;
  const { login, password } = logins.admin;
  assert.equal(await status("/session", "POST", { login, password: 1 }), 400);
  const response = await ask("/session", "POST", { login, password });
  const Cookie = response.headers.get("set-cookie").split(";")[0];
  const own = { Cookie, "X-Enamel-Csrf": (await response.json()).csrf };
  const station = `/stations/${mock.stations[0].id}`;
  assert.equal(await status("/stations"), 401);
  assert.equal(await status("/stations/of_old", "GET", undefined, own), 404);
  assert.equal(await status("/stations?limit=1000", "GET", undefined, own), 400);
  assert.equal(await status(station, "PATCH", { name: "A" }, { Cookie, "If-Match": '"1"' }), 403);
  assert.equal(await status(station, "PATCH", { name: "A" }, own), 428);
  assert.equal(await status(station, "PATCH", { title: "A" }, { ...own, "If-Match": '"1"' }), 400);
  assert.equal(await status(station, "PATCH", { name: "A" }, { ...own, "If-Match": '"0"' }), 412);
  assert.equal((await ask(station, "PATCH", { name: "A" }, { ...own, "If-Match": '"1"' })).headers.get("etag"), '"2"');
  assert.deepEqual(broken, []);
  mock.stations[0].revoked = "yes";
  assert.equal(await status("/stations", "GET", undefined, own), 500);
  assert.match(broken.splice(0).join(), /breaks the contract of GET \/stations, 200: stations\[0\]\.revoked: expected what should be boolean/);
}

// Runs one flow in browsers of its own; the page must not have logged an error or broken its policy.
export async function runFlow(flow, browser, { baseUrl, ...world }) {
  const opened = [];
  const open = async (options) => {
    opened.push(await openPage(browser, baseUrl, options));
    return opened.at(-1);
  };
  try {
    await flow.run({ open, baseUrl, ...world });
    assert.deepEqual(opened.flatMap(({ errors }) => errors), [], "errors in the browser's console");
  } catch (error) {
    await Promise.all(opened.map(({ page }, i) => page.screenshot({ path: world.picture(`failed_${i}`), fullPage: true }).catch(() => {})));
    throw error;
  } finally {
    await Promise.all(opened.map(({ context }) => context.close()));
  }
}
