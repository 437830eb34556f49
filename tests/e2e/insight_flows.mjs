// What those who teach and run a school see of classes, server and stations.
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { eventually } from "./browser.mjs";
import { isTargetLine, toothPixelsBecome } from "./pixels.mjs";
import { accessible, downloaded, looks, signedIn } from "./session.mjs";

const kRealMolar = join(
  process.env.ENAMEL_SHARED_DATA ?? fileURLToPath(new URL("../../../shared/data", import.meta.url)),
  "crowns/fdi_46.obj",
);

export const insightFlows = [
  {
    name: "an assignment says who has not begun, the most common mistake, and who is far from the class",
    run: classInsight,
  },
  { name: "what is wrong with the server is said first, with what to do", run: serverHealth },
  { name: "a backup is started, and why one cannot be is explained", run: backUp },
  {
    name: "an exercise is edited in a form: problems show while typing, edits are undone, compared, previewed and saved",
    run: editExercise,
  },
  { name: "a rubric that is published is corrected, with what it would do to past attempts", run: correctRubric },
  {
    name: "a device profile is edited, and a value that the server would refuse shows before saving",
    run: editProfile,
  },
  {
    name: "a new server's first admin makes an account from its link and is led through the first steps",
    run: firstAdmin,
  },
  { name: "a scan becomes a tooth on the page, and a wrong unit is reported with the right one", run: importTooth },
  { name: "one tooth is cut out of a scan of several, by points along its gum", run: cutOutTooth },
];

// Nothing is wider than the screen, at each of the sizes that people use.
async function pictures(world, page, name) {
  for (const [width, height] of looks([390, 800], [1280, 720], [1440, 900])) {
    await page.setViewportSize({ width, height });
    await world.picture(page, `${name}_${width}`, { fullPage: true });
    assert.equal(
      await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth),
      0,
      `${name} at ${width}: wider than the screen`,
    );
  }
}

async function classInsight(world) {
  const page = await signedIn(world, "instructor", world.assignment("graded"));
  const card = page.getByRole("region", { name: "The class" });
  await card.getByText("Most common mistake:").waitFor();
  await card.getByRole("img", { name: "Where the mistakes are, seen from above" }).waitFor();
  await eventually(async () => assert.match(await card.locator(".facts").innerText(), /Not started\s+\d+ of \d+/));
  const waiting = card.getByRole("region", { name: "Not started" });
  await eventually(async () =>
    assert.equal(
      await waiting.locator(".name-list").first().locator("li").count(),
      Number(/\((\d+)\)/.exec(await waiting.getByRole("heading").first().innerText())[1]),
    ),
  );
  await card
    .getByRole("region", { name: "Far from the class" })
    .getByText(/: Time in all attempts \d.*; class \d/)
    .first()
    .waitFor();
  await card.getByRole("region", { name: "Teaching staff" }).getByText("Instructor One").waitFor();
  await accessible(page, "the class of an assignment");
  const file = await downloaded(page, () => card.getByRole("button", { name: "Save as CSV" }).click());
  assert.match(
    file.text,
    /^\uFEFFlogin,display_name,state,attempts,score,released,failed_critically,time_s_all_attempts,/,
  );
  assert.match(file.text, /student,Student One,scored,/);
  await pictures(world, page, "class");
}

async function serverHealth(world) {
  const backups = mkdtempSync(join(tmpdir(), "enamel-backups-"));
  await world.opened.restart("--backups", backups);
  const admin = await world.as("admin");
  await admin.post("/backups", {});
  await eventually(async () => assert.ok((await admin.get("/health")).backup));
  const page = await signedIn(world, "admin", "/people");
  await page.getByRole("link", { name: "Health", exact: true }).click();
  await page.getByText("Nothing needs your attention").waitFor();
  await accessible(page, "a server that does well");
  await pictures(world, page, "health_well");
  rmSync(backups, { recursive: true });
  await world.opened.restart("--min-free-mib", "1048576"); // more than the disk has free
  await page.getByText("Recordings are not accepted").waitFor();
  const titles = await page.locator(".notice-title").allInnerTexts();
  assert.equal(titles[0], "Recordings are not accepted", "what loses work is said first");
  await accessible(page, "a server with trouble");
  await pictures(world, page, "health_trouble");
  await page.getByRole("link", { name: "All jobs" }).click();
  await page.getByRole("heading", { level: 1, name: "Jobs" }).waitFor();
}

async function backUp(world) {
  const folder = mkdtempSync(join(tmpdir(), "enamel-backups-"));
  try {
    const page = await signedIn(world, "admin", "/health");
    const button = page.getByRole("button", { name: "Back up now" });
    await page.getByText("No folder for backups is set.").waitFor();
    assert.equal(await button.count(), 0);
    await world.opened.restart("--backups", folder);
    await page.reload();
    await button.click();
    await eventually(async () => assert.equal(readdirSync(folder).length, 1));
    await eventually(async () => assert.ok(await button.isEnabled()));
    await page.getByText("No backup has been made yet").waitFor({ state: "detached" });
    await accessible(page, "a backup that was made");
    await pictures(world, page, "backup_made");
    rmSync(folder, { recursive: true });
    await button.click();
    await page.getByText("The backup was not started").waitFor();
    await page.getByText(/does not exist; mount its disk, or make the folder/).waitFor();
    await accessible(page, "a backup that was not started");
    await pictures(world, page, "backup_not_started");
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

async function editExercise(world) {
  const page = await signedIn(world, "admin", world.exercise("graded"));
  await page.getByRole("link", { name: "Edit as a new draft" }).click();
  await page.getByRole("heading", { level: 1, name: /New draft from Class I occlusal cavity/ }).waitFor();
  await page.getByText("No unsaved changes").waitFor();
  const title = page.getByLabel("Title", { exact: true });
  await title.fill("");
  await page.getByText("Has errors").first().waitFor();
  await eventually(async () => assert.equal(await title.getAttribute("aria-invalid"), "true"));
  await eventually(async () => assert.ok(await page.getByRole("button", { name: "Create the draft" }).isDisabled()));
  await accessible(page, "an exercise that is not right yet");
  await title.fill("Occlusal cavity, deeper");
  await page.getByText("Valid, not saved").waitFor();
  const depth = page.getByLabel("Depth (mm)");
  await toothPixelsBecome(page, "lines of the target", isTargetLine, (count) => count > 150);
  await depth.fill("");
  await page.getByText("Enter a size and a depth above zero to see the target.").waitFor();
  await toothPixelsBecome(page, "no lines", isTargetLine, (count) => count < 40);
  await depth.fill("2.5");
  await toothPixelsBecome(page, "lines of the new target", isTargetLine, (count) => count > 150);
  await page
    .getByRole("table", { name: "Changes from the published version" })
    .getByRole("row", { name: /Target, depth/ })
    .waitFor();
  for (let i = 0; i < 2; ++i) await page.getByRole("button", { name: "Add a bur" }).click();
  const second = page.getByRole("group", { name: "Bur 2", exact: true });
  await second.getByLabel("ISO 6360 number").fill("806 314 001 524 016");
  await page.getByRole("button", { name: "Remove bur 3" }).click();
  // The server knows which bur has this number.
  await page
    .getByText(/the bur's diameter in 1\/10 mm/)
    .first()
    .waitFor();
  await second.getByLabel("Radius (mm)", { exact: true }).fill("0.8");
  await page
    .getByText(/the bur's diameter in 1\/10 mm/)
    .first()
    .waitFor({ state: "detached" });
  await page
    .getByRole("table", { name: "Changes from the published version" })
    .getByRole("row", { name: /Burs to change to.*806 314 001 524 016/ })
    .waitFor();
  const first = page.getByRole("group", { name: "Floor", exact: true });
  const most = first.getByLabel("Never more than (points)");
  await most.fill("45");
  await first.getByText("It never costs more than 45.").waitFor();
  await page.getByRole("button", { name: "Check past attempts" }).click();
  await page.getByText("Mean score, now and new").waitFor();
  await page.getByRole("button", { name: "Try it" }).click();
  await page.getByText(/Target cut exactly: 100\.0 of 100/).waitFor();
  await page.getByText("Untouched tooth: 0.0 of 100").waitFor();
  await accessible(page, "an edited exercise");
  await pictures(world, page, "exercise_editor");
  await page.setViewportSize({ width: 1280, height: 900 });
  await page.getByRole("button", { name: "Undo", exact: true }).click();
  await eventually(async () => assert.notEqual(await most.inputValue(), "45"));
  await page.getByText("The rubric has changed since. Check again.").waitFor();
  await page.getByRole("button", { name: "Redo", exact: true }).click();
  await eventually(async () => assert.equal(await most.inputValue(), "45"));
  await page.getByRole("button", { name: "Add a criterion" }).click();
  await page
    .getByRole("group", { name: /^Criterion \d+:/ })
    .last()
    .getByRole("button", { name: /^Move up/ })
    .click();
  await page.getByRole("button", { name: "Undo", exact: true }).click();
  await page.getByRole("button", { name: "Undo", exact: true }).click();
  // What was typed outlives the page.
  await page.reload();
  await page.getByText("Unsaved changes restored").waitFor();
  await eventually(async () => assert.equal(await title.inputValue(), "Occlusal cavity, deeper"));
  await page.getByText("Valid, not saved").waitFor();
  await page.getByRole("button", { name: "Create the draft" }).click();
  await page.getByRole("heading", { level: 1, name: "Occlusal cavity, deeper" }).waitFor();
  const admin = await world.as("admin");
  const { exercises } = await admin.get("/exercises?state=draft");
  const draft = exercises.find((row) => row.title === "Occlusal cavity, deeper");
  const document = await admin.get(`/exercises/${draft.id}/document`);
  const floor = document.rubric.prices.find(({ of }) => of === "floor");
  assert.deepEqual([document.target.depth_um, floor.most], [2500, 45]);
  await page.getByRole("link", { name: "Edit the draft" }).click();
  await page.getByText("No unsaved changes").waitFor();
  assert.equal(await page.getByText("Unsaved changes restored").count(), 0);
}

async function correctRubric(world) {
  const page = await signedIn(world, "admin", world.exercise("graded"));
  await page.getByRole("link", { name: "Correct the rubric" }).click();
  await page.getByText("No unsaved changes").waitFor();
  const publish = page.getByRole("button", { name: "Publish the correction" });
  await eventually(async () => assert.equal(await whyGrey(page, publish), "Nothing has changed yet."));
  const first = page.getByRole("group", { name: /^Criterion 1:/ });
  const share = first.getByLabel("Share of the points kept (%)").nth(1);
  await share.fill("140");
  await first.getByText("Enter a number from 0 to 100.").waitFor();
  await share.fill("10");
  await wrongPoints(world, page, first, publish);
  await page.getByText("Valid, not saved").waitFor();
  await eventually(async () => assert.equal(await whyGrey(page, publish), "Give the reason for the correction first."));
  await page.getByLabel("Reason").fill("Colleagues found it too strict.");
  await page.getByRole("button", { name: "Check past attempts" }).click();
  await page.getByText("Would rise").waitFor();
  await accessible(page, "a rubric being corrected");
  await pictures(world, page, "rubric_editor");
  await publish.click();
  await page.getByRole("heading", { level: 1, name: "Class I occlusal cavity" }).waitFor();
  const { rubrics } = await (await world.as("admin")).get(`${world.exercise("graded")}/rubrics`);
  const [counts] = rubrics;
  assert.equal(counts.version, 2);
  assert.equal(counts.document.criteria[0].map[1][1], 0.1);
  await page.goto(`/editor?rubric=${world.school.exercises.graded}`);
  await page.getByLabel("Compare with").selectOption("1");
  await page.getByRole("table", { name: "Changes from the selected version" }).waitFor();
}

// What is said beside a button that cannot be pressed; undefined: it can.
async function whyGrey(page, button) {
  if (await button.isEnabled()) return undefined;
  return page.locator(`[id="${await button.getAttribute("aria-describedby")}"]`).innerText();
}

// A wrong number is reported at once, at its field and in words above; both disappear when it is
// right.
async function wrongPoints(world, page, criterion, publish) {
  const points = criterion.getByLabel("Costs at most (points)");
  const kept = await points.inputValue();
  const told = page.locator(".edit-notices .notice");
  for (const [typed, said] of [
    ["-5", /Enter a number from 0 to 1.000\.$/],
    ["", /Enter a number\.$/],
    ["2000", /Enter a number from 0 to 1.000\.$/],
  ]) {
    await points.fill(typed);
    await criterion.getByText(said).waitFor();
    assert.equal(await points.getAttribute("aria-invalid"), "true");
    assert.match(await told.innerText(), /[^/]+, points: Enter a number/);
    assert.doesNotMatch(await page.locator("main").innerText(), /\/criteria|\dE\d/);
    assert.ok(await publish.isDisabled());
  }
  const answered = page.waitForResponse(
    (response) => response.request().postData()?.includes('"points":null') ?? false,
  );
  await points.fill("");
  await points.focus();
  await page.keyboard.insertText("1e999"); // pasted: more than a number can be
  await criterion.getByText(/Enter a number\.$/).waitFor();
  await answered;
  await eventually(async () => assert.match(await told.innerText(), /[^/]+, points: Enter a number\.$/));
  await accessible(page, "a rubric with a wrong number");
  await pictures(world, page, "rubric_wrong");
  await points.fill(kept);
  await told.waitFor({ state: "detached" });
  await eventually(async () => assert.equal(await points.getAttribute("aria-invalid"), null));
}

async function editProfile(world) {
  const page = await signedIn(world, "admin", "/profiles/phantom_desktop");
  await page.getByRole("link", { name: "Edit numbers" }).click();
  await page.getByText("No unsaved changes").waitFor();
  await page.getByLabel("Coupling (mN/mm)", { exact: true }).fill("9000");
  await page.getByText("The server would refuse it").waitFor();
  await page.getByText("Not met").first().waitFor();
  await eventually(async () => assert.ok(await page.getByRole("button", { name: "Save as version 2" }).isDisabled()));
  await accessible(page, "a profile that would be refused");
  await pictures(world, page, "profile_editor");
  await page.getByLabel("Coupling (mN/mm)", { exact: true }).fill("1100");
  await page.getByText("Valid, not saved").waitFor();
  await page.getByRole("button", { name: "Save as version 2" }).click();
  await page.getByRole("heading", { level: 1, name: "Phantom Desktop" }).waitFor();
}

async function firstAdmin(world) {
  const [, token] = /\/first#([0-9a-f]{64})/.exec(await world.opened.empty());
  const page = await world.open({ width: 1280, height: 900 });
  await page.goto(`/first#${"cd".repeat(32)}`);
  await page.getByRole("heading", { name: "First admin" }).waitFor();
  await accessible(page, "making the first admin");
  await pictures(world, page, "first_admin");
  await page.getByLabel("Name", { exact: true }).fill("Head of School");
  await page.getByLabel("Login").fill("head");
  await page.getByLabel("Password").fill("short one");
  await page.getByRole("button", { name: "Create the account" }).click();
  await page.getByText(/This link has expired or was used/).waitFor();
  await page.goto("/");
  await page.goto(`/first#${token}`);
  await page.getByLabel("Name", { exact: true }).fill("Head of School");
  await page.getByLabel("Login").fill("head");
  await page.getByLabel("Password").fill("short one");
  await page.getByRole("button", { name: "Create the account" }).click();
  await page.getByText(/this password is among the first that are guessed/i).waitFor();
  await page.getByLabel("Password").fill("quite a long phrase of mine");
  await page.getByRole("button", { name: "Create the account" }).click();
  await page.getByRole("heading", { level: 2, name: /First steps, \d of 6 done/ }).waitFor();
  assert.equal(new URL(page.url()).hash, "", "the token does not stay in the address");
  await accessible(page, "the first steps");
  await pictures(world, page, "first_steps");
  // Also for the second tooth, when the first step is done.
  await page.getByRole("link", { name: "Add a tooth…" }).click();
  const dialog = page.getByRole("dialog", { name: "Add a tooth" });
  for (const tooth of ["molar", "block"]) {
    await dialog.getByLabel("Built-in tooth").selectOption(tooth);
    await dialog.getByRole("button", { name: "Add it" }).click();
    await dialog.getByText(/exercises? published/).waitFor();
  }
  await page.goto("/health");
  await page.locator(".steps li", { hasText: "Teeth and exercises" }).getByText("done").waitFor();
}

async function importTooth(world) {
  if (!existsSync(kRealMolar)) {
    console.log(`skipped: ${kRealMolar} is not there`);
    return;
  }
  const page = await signedIn(world, "admin", "/exercises");
  await page.getByRole("button", { name: "Add a tooth…" }).click();
  const dialog = page.getByRole("dialog", { name: "Add a tooth" });
  await dialog.getByLabel("Mesh of a crown or tooth").setInputFiles(kRealMolar);
  await dialog.getByLabel("Name", { exact: true }).fill("Molar of the collection");
  await dialog.getByLabel("Tooth", { exact: true }).selectOption("46");
  await dialog.getByLabel("Unit or scale of the coordinates").selectOption("um");
  await accessible(page, "importing a tooth");
  await dialog.getByRole("button", { name: "Show the tooth" }).click();
  await dialog.getByText("This file cannot be turned into a tooth").waitFor();
  await eventually(async () =>
    assert.match(
      await dialog.getByRole("alert").innerText(),
      /found one of 0\.01\d+ mm with the unit 'um': its numbers look like mm/,
    ),
  );
  await accessible(page, "a mesh that is refused");
  await pictures(world, page, "tooth_refused");
  await dialog.getByLabel("Unit or scale of the coordinates").selectOption("mm");
  await dialog.getByRole("button", { name: "Show the tooth" }).click();
  await dialog.locator(".tooth-frame[aria-busy=false] canvas").waitFor({ timeout: 120_000 });
  // The file has it upright along +y, and the importer finds that. Laid on its side, as by a wrong guess, it is stood up
  // again.
  const turn = async (axis, ...turns) => {
    const group = dialog.getByRole("group", { name: `Turn about the axis: ${axis}` });
    for (const degrees of turns) await group.getByRole("button", { name: degrees, exact: true }).click();
  };
  const upAfter = async (button, done) => {
    const begun = page.waitForResponse((response) => response.url().endsWith("/tooth-imports"));
    await dialog.getByRole("button", { name: button, exact: true }).click();
    const { id } = await (await begun).json();
    await done.waitFor({ timeout: 120_000 });
    const { stance } = await page.evaluate(
      (path) => fetch(path).then((got) => got.json()),
      `/api/v1/tooth-imports/${id}`,
    );
    return stance.up;
  };
  await pictures(world, page, "tooth_shown");
  await turn("Mesial", "+90°");
  await accessible(page, "a tooth that was turned");
  const lying = await upAfter(
    "Show the tissues for this position",
    dialog.getByText("The tooth is shown as it was turned."),
  );
  assert.ok(Math.abs(lying[1]) < 0.2, "it lies on its side");
  await dialog.getByRole("button", { name: "Section" }).click();
  await dialog.locator(".stance .legend", { hasText: "Dentin" }).waitFor();
  await pictures(world, page, "tooth_on_its_side");
  await turn("Mesial", "+90°", "+90°", "+90°", "−5°", "+5°");
  const standing = await upAfter("Publish", dialog.getByText(/\d exercises? published, not assigned to anybody yet/));
  assert.ok(standing[1] > 0.98, "it was published upright");
  await accessible(page, "a tooth that was imported");
  await dialog.getByRole("button", { name: "Close" }).click();
  await dialog.waitFor({ state: "detached" });
}

// Three round crowns of a radius of 3.5 mm, 12 mm apart, on a flat gum of 36 x 20 mm, as binary STL.
function threeCrowns() {
  const kStep = 0.25;
  const height = (x, y) => {
    const off = Math.min(...[-12, 0, 12].map((at) => Math.hypot(x - at, y)));
    return off >= 3.5 ? 0 : 5 * Math.min(1, (3.5 - off) / 0.5);
  };
  const at = (x, y) => [x, y, height(x, y)];
  const triangles = [];
  for (let x = -18; x < 18; x += kStep)
    for (let y = -10; y < 10; y += kStep) {
      const [a, b, c, d] = [at(x, y), at(x + kStep, y), at(x + kStep, y + kStep), at(x, y + kStep)];
      triangles.push([a, b, c], [a, c, d]);
    }
  const out = Buffer.alloc(84 + 50 * triangles.length);
  out.writeUInt32LE(triangles.length, 80);
  triangles.forEach((corners, i) => {
    corners.flat().forEach((value, k) => {
      out.writeFloatLE(value, 84 + 50 * i + 12 + 4 * k);
    });
  });
  return out;
}

async function cutOutTooth(world) {
  const page = await signedIn(world, "admin", "/exercises");
  await page.getByRole("button", { name: "Add a tooth…" }).click();
  const dialog = page.getByRole("dialog", { name: "Add a tooth" });
  await dialog
    .getByLabel("Mesh of a crown or tooth")
    .setInputFiles({ name: "jaw.stl", mimeType: "model/stl", buffer: threeCrowns() });
  await dialog.getByLabel("The file holds several teeth").check();
  await dialog.getByLabel("Name", { exact: true }).fill("Molar of the scan");
  await dialog.getByLabel("Tooth", { exact: true }).selectOption("46");
  await accessible(page, "a scan of several teeth");
  await dialog.getByRole("button", { name: "Show the scan" }).click();
  const frame = dialog.locator(".tooth-frame[aria-busy=false]");
  await frame.locator("canvas").waitFor({ timeout: 120_000 });
  await dialog.getByText("No points yet.").waitFor();
  // From above, nothing of the gum is hidden.
  await frame.focus();
  for (let i = 0; i < 8; ++i) await page.keyboard.press("ArrowUp");
  await pictures(world, page, "jaw");
  await page.setViewportSize({ width: 1280, height: 720 });
  await frame.scrollIntoViewIfNeeded();
  const box = await frame.locator("canvas").boundingBox();
  const around = async (share, points) => {
    for (let i = 0; i < points; ++i) {
      const angle = (2 * Math.PI * i) / points;
      const [x, y] = [Math.cos(angle), Math.sin(angle)].map((part) => share * box.height * part);
      await page.mouse.click(box.x + box.width / 2 + x, box.y + box.height / 2 + y);
      await page.mouse.move(box.x, box.y);
      await dialog.getByText(new RegExp(`^${i + 1} points?\\.$`)).waitFor();
    }
  };
  await around(0.14, 10);
  await dialog.getByRole("button", { name: "Remove the last point" }).click();
  await dialog.getByText("9 points.").waitFor();
  await accessible(page, "points along a gum");
  await pictures(world, page, "jaw_points");
  const begun = page.waitForRequest((request) => request.url().endsWith("/tooth-imports"));
  await dialog.getByRole("button", { name: "Show the tooth" }).click();
  assert.ok(JSON.parse((await begun).postData()).mesh_of, "the file is sent once");
  await dialog.getByText(/^The occlusal direction/).waitFor({ timeout: 120_000 });
  await pictures(world, page, "jaw_tooth");
  await dialog.getByRole("button", { name: "Back to the scan" }).click();
  await dialog.getByText("9 points.").waitFor();
}
