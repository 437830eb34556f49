// What instructors and students do with exercises, assignments and attempts.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { golden } from "./contract.mjs";
import { id } from "./mock_exercises.mjs";
import { accessible, chooseFile, signedIn } from "./session.mjs";

export const teachingFlows = [
  {
    name: "an exercise document is refused with the field, then becomes a draft and is published and retired",
    run: exerciseLife,
  },
  { name: "an instructor makes an exercise of another one, and goes on in the editor", run: copyExercise },
  {
    name: "an exercise is assigned, its terms edited against somebody else's, its scores released, and deleted",
    run: assignmentLife,
  },
  { name: "a teacher remarks at a point of the tooth and at the tool, and the student reads it there", run: remarks },
  { name: "an attempt that was just opened is at its end for the picture, the plots and a remark", run: oneMoment },
  { name: "remarks are written by keyboard, and the focus stays there", run: remarksByKeys },
  { name: "a set score shows beside the computed one, and can be removed", run: override },
  { name: "a score that two people set at once shows both, and one of them counts", run: overrideConflict },
  { name: "a rescored attempt shows that it waits, and then that it is done", run: rescoreToItsEnd },
  { name: "a student appeals once, and the answer grades again", run: appeal },
  { name: "an attempt that was stopped early shows how far it came", run: stoppedEarly },
  { name: "stations in use are seen live, and one is watched until it ends", run: live },
  ...(process.env.ENAMEL_FULL
    ? [{ name: "forty stations on one screen take at most a megabit a second", run: fortyLive }]
    : []),
  { name: "a reference is withdrawn", run: withdrawReference },
  { name: "a student sees how the criteria come on and what to work at next", run: progress },
  { name: "a student's result prints as a document", run: print },
];

const kWallSeconds = 20;

const kDocument = { ...golden("scene_exercise_gates"), name: "class-1-new", title: "A new cavity" };

async function exerciseLife(world) {
  const page = await signedIn(world, "instructor", "/exercises");
  await page.getByRole("button", { name: "New exercise…" }).click();
  await page.getByText("From a document instead").click();
  await accessible(page, "adding a draft");
  await chooseFile(
    page,
    "Exercise document (JSON)",
    "new.json",
    JSON.stringify({ ...kDocument, rubric: { ...kDocument.rubric, criteria: [] } }),
  );
  await page.getByRole("button", { name: "Add", exact: true }).click();
  await page.getByText("The document has errors").waitFor();
  await eventually(async () => assert.match(await page.getByRole("alert").innerText(), /rubric\.criteria: expected/));
  await accessible(page, "a refused document");
  await chooseFile(page, "Exercise document (JSON)", "new.json", JSON.stringify(kDocument));
  await page.getByRole("button", { name: "Add", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "A new cavity" }).waitFor();
  await page.getByRole("button", { name: "Publish…" }).click();
  await page.getByRole("button", { name: "Publish", exact: true }).click();
  await page.getByText("Published. It can now be assigned.").waitFor();
  const published = page.url();
  await page.goto("/assignments");
  await page.getByRole("button", { name: "Assign an exercise…" }).click();
  await page.getByRole("dialog").getByLabel("Exercise").selectOption({ label: "A new cavity (no reference yet)" });
  await page.goto(published);
  await page.getByText(/version 1 · .*, private/).waitFor();
  await page.getByRole("button", { name: "Share…" }).click();
  await page.getByRole("button", { name: "Share", exact: true }).click();
  await page.getByText(/version 1 · .*, shared/).waitFor();
  await page.getByRole("button", { name: "Retire…" }).click();
  await page.getByRole("button", { name: "Retire", exact: true }).click();
  await page.locator(".badge", { hasText: "Retired" }).first().waitFor();
  await page.getByRole("navigation", { name: "You are here" }).getByRole("link").click();
  await page.getByLabel("Retired").check();
  await page.getByRole("link", { name: "A new cavity" }).waitFor();
}

// Others' exercises too, which may not be changed.
async function copyExercise(world) {
  const page = await signedIn(world, "instructor", "/exercises");
  await page.getByRole("button", { name: "New exercise…" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Copy of").selectOption({ label: "Class II cavity, mesial box" });
  await dialog.getByLabel("Title").fill("Class II, term 2");
  await eventually(async () => assert.equal(await dialog.getByLabel("Name").inputValue(), "class-ii-term-2"));
  await dialog.getByLabel("Name").fill("Class II");
  await dialog.getByText("Use only small letters").waitFor();
  const make = dialog.getByRole("button", { name: "Make the draft" });
  const why = await dialog.getByText("Still needed: Name", { exact: true }).getAttribute("id");
  assert.equal(await make.getAttribute("aria-describedby"), why);
  await make.focus();
  assert.ok(await make.evaluate((button) => document.activeElement === button), "a grey button is in the tab order");
  await dialog.getByLabel("Name").press("Enter");
  await make.click({ force: true });
  assert.ok(!world.mock.exercises.some(({ name }) => name === "Class II"), "a grey button sends nothing");
  await dialog.getByLabel("Name").fill("class-2-second");
  await accessible(page, "copying an exercise");
  await world.picture(page, "copy_exercise");
  await make.click();
  await page.waitForURL(/\/editor\?exercise=/);
  await eventually(async () => assert.equal(await page.getByLabel("Title").first().inputValue(), "Class II, term 2"));
  const material = page.getByLabel("Restorative material");
  assert.equal(await material.inputValue(), "amalgam");
  assert.deepEqual(await material.locator("option").allInnerTexts(), ["Not named", "Amalgam", "Composite"]);
  await material.selectOption({ label: "Composite" });
  await page.getByRole("button", { name: "Save the draft" }).click();
  await page.getByText("Amalgam: mesial and distal walls may diverge").waitFor();
  assert.equal(world.mock.documents.get(page.url().split("/").at(-1)).rubric.restoration, "composite");
}

async function assignmentLife(world) {
  const page = await signedIn(world, "instructor", "/assignments");
  await page.getByRole("button", { name: "Assign an exercise…" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Exercise").selectOption({ label: "Class II cavity, mesial box" });
  await dialog.getByLabel("Cohort").selectOption({ label: "Preclinic, second term" });
  await dialog.getByLabel("Due").fill("2020-03-09T09:00");
  await dialog.getByText("This time has passed, so nobody could start.").waitFor();
  await dialog.getByLabel("Opens").fill("2027-03-10T09:00");
  await dialog.getByLabel("Due").fill("2027-03-09T09:00");
  await dialog.getByText("Choose a time after the assignment opens.").waitFor();
  await dialog.getByRole("checkbox", { name: "Exam" }).check();
  await dialog.getByRole("checkbox", { name: "An instructor signs at the chair" }).check();
  await dialog.getByRole("checkbox", { name: "Station 3" }).check();
  await accessible(page, "a new assignment");
  await world.picture(page, "assign");
  await dialog.getByRole("button", { name: "Assign", exact: true }).click();
  await dialog.getByText("Choose a time after the assignment opens.").waitFor();
  await dialog.getByLabel("Due").fill("2027-03-12T09:00");
  await dialog.getByRole("button", { name: "Assign", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Class II cavity, mesial box" }).waitFor();
  const made = world.mock.assignments.at(-1);
  assert.equal(made.exam, true);
  assert.equal(made.stations.length, 1);
  assert.equal(made.sign_off, true);
  // Practice has no signatures.
  await page.getByRole("checkbox", { name: "Exam" }).uncheck();
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await eventually(async () => assert.deepEqual([made.exam, made.sign_off], [false, false]));
  await page.getByRole("checkbox", { name: "Exam" }).check();
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await eventually(async () => assert.deepEqual([made.exam, made.sign_off], [true, false]));

  Object.assign(made, { attempt_limit: 7, revision: made.revision + 1 });
  await page.getByLabel("Attempts per student").fill("2");
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByText("Somebody else has changed this").waitFor();
  await eventually(async () =>
    assert.match(
      await page.getByRole("table", { name: "Differences" }).innerText(),
      /Attempts\s+7 attempts\s+2 attempts/,
    ),
  );
  await page.getByRole("button", { name: "Use their version" }).click();
  await eventually(async () => assert.equal(await page.getByLabel("Attempts per student").inputValue(), "7"));
  await page.getByRole("button", { name: "Delete the assignment…" }).click();
  await page.getByRole("button", { name: "Delete", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Assignments" }).waitFor();
  assert.ok(!world.mock.assignments.includes(made) || world.mock.assignments.every((row) => row.id !== made.id));

  // A newer version changes nothing until somebody moves the assignment.
  const first = world.mock.exercises.find((row) => row.name === "class-1-occlusal" && row.state === "published");
  const running = world.mock.assignments.find((row) => row.id === id(500));
  running.version = first;
  world.mock.exercises.push({ ...first, id: id(990), version: first.version + 1 });
  await page.getByRole("link", { name: "Occlusal cavity, class I", exact: true }).click();
  await page.getByRole("button", { name: `Move to version ${first.version + 1}…` }).click();
  await page.getByText(/attempts made with other versions keep their versions/).waitFor();
  await accessible(page, "moving an assignment");
  await page.getByRole("button", { name: "Move", exact: true }).click();
  await page.getByRole("link", { name: `Exercise, version ${first.version + 1}` }).waitFor();
  assert.equal(running.version.id, id(990));
  await page.getByRole("button", { name: "Release all scores…" }).click();
  await page.getByRole("button", { name: "Release all", exact: true }).click();
  await page.getByText(/\d+ scores released/).waitFor();
  assert.ok(
    world.mock.attempts
      .filter((row) => row.assignment_id === id(500) && row.state === "scored")
      .every((row) => row.released),
  );
}

async function remarks(world) {
  const path = `/attempts/${id(105)}`;
  const page = await signedIn(world, "instructor", path);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".annotations").waitFor();
  const box = await page.locator(".tooth-frame").boundingBox();
  await page.mouse.click(box.x + box.width * 0.3, box.y + box.height * 0.7);
  await page.getByText("At the point", { exact: false }).waitFor();
  await page.getByRole("button", { name: "Point of the new remark" }).waitFor();
  await page.getByLabel("Time in the attempt").fill("500");
  await page.getByLabel("New remark at 0:12.0").fill("Look at this place.");
  await accessible(page, "a remark being written");
  await page.getByRole("button", { name: "Add remark" }).click();
  await page.getByText("Look at this place.").waitFor();
  const made = world.mock.annotations.at(-1);
  assert.equal(made.tick, 12_000);
  assert.ok(
    made.point_um.every((um) => Number.isInteger(um) && Math.abs(um) < 8000),
    `a point on the tooth, found ${made.point_um}`,
  );

  await page.getByRole("button", { name: "Use the tool’s position" }).click();
  await page.getByLabel(/New remark/).fill("And where the tool is.");
  await page.getByRole("button", { name: "Add remark" }).click();
  await page.getByText("And where the tool is.").waitFor();
  await page.getByRole("button", { name: "Edit remark 2" }).click();
  await page.getByLabel("Remark", { exact: true }).fill("Look at this very place.");
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByText("Look at this very place.").waitFor();
  await world.picture(page, "remarks", { fullPage: true });
  await page.getByRole("button", { name: "Delete… remark 3" }).click();
  await page.getByRole("button", { name: "Delete remark", exact: true }).click();
  // Until it is closed the question quotes the remark too.
  await page.getByRole("dialog").waitFor({ state: "detached" });
  await page.getByText("And where the tool is.").waitFor({ state: "detached" });

  const student = await signedIn(world, "student", path);
  await student.getByText("Look at this very place.").waitFor();
  assert.equal(await student.getByRole("button", { name: "Add remark" }).count(), 0);
  await eventually(async () =>
    assert.match(
      await student.locator(".annotation", { hasText: "Good light touch" }).innerText(),
      /sent to the station/,
    ),
  );
  await eventually(async () => assert.equal(await student.getByText("sent to the station").count(), 1));
  await student
    .getByRole("group", { name: "Remarks on the timeline" })
    .getByRole("button", { name: "Remark 2" })
    .click();
  await eventually(async () => assert.equal(await student.getByLabel("Time in the attempt").inputValue(), "500"));
}

async function oneMoment(world) {
  const page = await signedIn(world, "instructor", `/attempts/${id(105)}`);
  await page.locator('.playback[data-shown="432"]').waitFor();
  const slider = page.getByLabel("Time in the attempt");
  await page.locator(".plot canvas").waitFor();
  await eventually(async () => assert.equal(await page.locator(".playback-time").innerText(), "0:43.2"));
  await eventually(async () => assert.equal(await slider.inputValue(), await slider.getAttribute("max")));
  await eventually(async () => assert.match(await page.locator(".readout").innerText(), /0:43\.2/));
  const [cursor, plot] = [
    await page.locator(".plot-cursor").first().boundingBox(),
    await page.locator(".force-card .u-over").boundingBox(),
  ];
  assert.ok(
    Math.abs(cursor.x + cursor.width / 2 - plot.x - plot.width) < 2,
    `the plot's cursor is at ${cursor.x} of ${plot.x + plot.width}`,
  );
  await page.getByLabel("New remark at 0:43.2").fill("The floor is even.");
  await world.picture(page, "one_moment", { fullPage: true });
  await page.getByRole("button", { name: "Add remark" }).click();
  await page.getByRole("button", { name: /Remark \d: show 0:43\.2/ }).waitFor();
  assert.equal(world.mock.annotations.at(-1).tick, 43_200);
}

const focusIsInRemark = (page) => page.waitForFunction(() => document.activeElement?.matches(".new-remark textarea"));

// Writing, the next mark and another remark, without the mouse.
async function remarksByKeys(world) {
  const page = await signedIn(world, "instructor", `/attempts/${id(105)}`);
  await page.locator('.playback[data-shown="432"]').waitFor();
  await page.locator(".spans .span.lost").first().waitFor();
  await page.locator("body").click({ position: { x: 5, y: 300 } });
  await page.keyboard.press("x");
  await page.waitForFunction(() => Number(document.querySelector(".playback").dataset.shown) < 300);
  await page.keyboard.press("c");
  await focusIsInRemark(page);
  await page.keyboard.type("Too fast here.");
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await page.locator(".annotation", { hasText: "Too fast here." }).waitFor();
  await focusIsInRemark(page);
  await page.keyboard.type("Lift the bur.");
  await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await page.locator(".annotation", { hasText: "Lift the bur." }).waitFor();
  await focusIsInRemark(page);
  await page
    .getByRole("button", { name: /^Edit remark/ })
    .last()
    .press("Enter");
  await page.getByLabel("Remark", { exact: true }).fill("Lift the bur more.");
  await page.getByRole("button", { name: "Save", exact: true }).press("Enter");
  await page.locator(".annotation", { hasText: "Lift the bur more." }).waitFor();
  await page.waitForFunction(() => /^Edit/.test(document.activeElement?.innerText ?? ""));
}

async function override(world) {
  const page = await signedIn(world, "instructor", `/attempts/${id(120)}`);
  await page.getByRole("button", { name: "Override score…" }).click();
  const field = page.getByLabel("New score, 0 to 100");
  await eventually(async () => assert.equal(await field.inputValue(), "71.4"));
  assert.equal(await field.evaluate((input) => input.checkValidity()), true, "what the field begins with may be sent");
  await field.fill("88.5");
  await page.getByLabel("Reason").fill("The lesion reached the mesial wall.");
  await accessible(page, "setting a score");
  await page.getByRole("button", { name: "Set this score" }).click();
  await page.getByText("Set by Instructor One: 88.5 instead of 71.4").waitFor();
  await page.getByTestId("score").filter({ hasText: "88.5" }).waitFor();
  await accessible(page, "a set score");
  await world.picture(page, "override", { fullPage: true });
  const student = await signedIn(world, "student", `/attempts/${id(120)}`);
  await student.getByText("The lesion reached the mesial wall.").waitFor();
  await page.getByRole("button", { name: "Remove override…" }).click();
  await page.getByRole("button", { name: "Remove override", exact: true }).click();
  await page.getByText("The computed score counts again.").first().waitFor();
  await page.getByTestId("score").filter({ hasText: "71.4" }).waitFor();
}

async function overrideConflict(world) {
  const page = await signedIn(world, "instructor", `/attempts/${id(120)}`);
  await page.getByRole("button", { name: "Override score…" }).click();
  await page.getByLabel("New score, 0 to 100").fill("88.5");
  await page.getByLabel("Reason").fill("The lesion reached the mesial wall.");
  const other = await world.open();
  const { login, password } = world.logins.admin;
  const session = await (await other.context().request.post("/api/v1/session", { data: { login, password } })).json();
  const path = `/api/v1/attempts/${id(120)}`;
  const tag = (await other.context().request.get(path)).headers().etag;
  const set = await other.context().request.put(`${path}/override`, {
    headers: { "If-Match": tag, "X-Enamel-Csrf": session.csrf },
    data: { score: 60, reason: "The bur was worn." },
  });
  assert.equal(set.status(), 200, await set.text());
  await page.getByRole("button", { name: "Set this score" }).click();
  const both = page.getByRole("table", { name: "Differences" });
  await both.getByRole("row", { name: /60\.0.*88\.5/ }).waitFor();
  await both.getByRole("row", { name: /The bur was worn.*The lesion reached/ }).waitFor();
  await accessible(page, "two set scores");
  await page.getByRole("button", { name: "Save my version" }).click();
  await page.getByText("Set by Instructor One: 88.5 instead of 71.4").waitFor();
}

async function rescoreToItsEnd(world) {
  const page = await signedIn(world, "instructor", `/attempts/${id(120)}`);
  await page.getByRole("button", { name: "Rescore…" }).click();
  await page.getByRole("button", { name: "Rescore", exact: true }).click();
  await page.getByText("Waiting to be rescored.").waitFor();
  await page.getByText("The attempt was rescored.").waitFor();
  assert.equal(await page.getByText("Waiting to be rescored.").count(), 0);
  await page.getByTestId("score").filter({ hasText: "80.0" }).waitFor();
}

async function appeal(world) {
  const path = `/attempts/${id(120)}`;
  const student = await signedIn(world, "student", path);
  await student.getByRole("button", { name: "Appeal against the score…" }).click();
  await student.getByLabel("What should be checked again, and why").fill("The bur was worn.");
  await accessible(student, "an appeal being written");
  await student.getByRole("button", { name: "Send the appeal" }).click();
  await student.getByText("Not answered yet").waitFor();
  assert.equal(await student.getByRole("button", { name: "Appeal against the score…" }).count(), 0);

  const page = await signedIn(world, "instructor", "/attempts");
  await page.getByText("2 appeals to answer").waitFor();
  await page.locator("tbody tr", { hasText: "Unanswered appeal" }).first().waitFor();
  await page.getByRole("button", { name: "Show them" }).click();
  await page
    .getByRole("row", { name: /Student One/ })
    .getByRole("link")
    .first()
    .click();
  await page.getByLabel("Your answer").fill("We replay it.");
  await page.getByRole("button", { name: "Answer and rescore" }).click();
  await page.getByRole("progressbar", { name: "Replaying and scoring" }).waitFor();
  await page.getByText("Rescored").waitFor();
  await page.getByRole("region", { name: "Scored more than once" }).waitFor();
  await accessible(page, "an answered appeal");
}

async function stoppedEarly(world) {
  const page = await signedIn(world, "instructor", `/attempts/${id(605)}`);
  await page.locator(".byline", { hasText: "Stopped early: 46 % done" }).waitFor();
  await page.getByText("Only 46 % of the task was done").waitFor();
}

async function live(world) {
  const page = await signedIn(world, "instructor", "/assignments");
  // Each tooth comes broken at first, and is asked for again.
  const broken = new Set();
  await page.route("**/initial-surface", (route) => {
    const address = route.request().url();
    if (broken.has(address)) return route.continue();
    broken.add(address);
    return route.fulfill({ body: "cut short" });
  });
  await page.goto("/live");
  await page.locator(".live-card .badge.good").nth(2).waitFor();
  await eventually(async () => assert.equal(await page.locator(".live-card").count(), 4));
  await page.waitForFunction(
    () => [...document.querySelectorAll(".live-force b")].every((force) => /\sN$/.test(force.textContent)),
    undefined,
    { timeout: 20_000 },
  );
  await page.getByText(/\d+\smin\s\d\d\ss left of 10\smin/).waitFor();
  await eventually(async () => assert.ok((await page.getByText(/no time limit/).count()) >= 3));
  // The tooth of each is under the tool.
  await page
    .getByRole("img", { name: /^Tool from above: .*of the crown’s middle$/ })
    .nth(2)
    .waitFor();
  await page
    .getByText(/^Cut so far: up to [\d.]+\smm deep$/)
    .nth(2)
    .waitFor();
  await world.picture(page, "live", { fullPage: true });
  await page.getByRole("link", { name: "Station 1" }).click();
  await page.getByText("Largest in 20 s").waitFor();
  await page.getByText(/^Cut so far: up to [1-9][\d.]*\smm deep$/).waitFor();
  await eventually(async () =>
    assert.match(
      await page.getByRole("img", { name: /^Force over the last/ }).getAttribute("aria-label"),
      /at most [\d.]+ N/,
    ),
  );
  const chair = page.getByRole("region", { name: "Send a remark to the station" });
  await chair.getByLabel("Remark").fill("Stop: the mesial wall is thin. 请停一下。");
  await chair.getByRole("button", { name: "Send to the station" }).click();
  await chair.locator(".badge", { hasText: "Shown" }).waitFor();
  await eventually(async () =>
    assert.match(await chair.getByRole("listitem").innerText(), /请停一下。[\s\S]*at 1\smin\s12\ss/),
  );
  await eventually(async () => assert.equal(await chair.getByLabel("Remark").inputValue(), ""));
  await accessible(page, "a watched attempt");
  await world.picture(page, "said", { fullPage: true });
  world.mock.attempts[0].chair = { connected: true, shows_remarks: false };
  await chair.getByText(/software is too old to show remarks/).waitFor();
  Object.assign(world.mock.attempts[0], { state: "sealed", sealed_ms: Date.now() });
  await page.getByText("This attempt is finished").waitFor();
}

async function fortyLive(world) {
  const made = world.mock.attempts.filter(({ state }) => state === "recording");
  for (let i = made.length; i < 40; ++i) {
    const like = made[i % made.length];
    world.mock.attempts.push({ ...like, id: id(7000 + i), station: { ...like.station, name: `Station ${i + 1}` } });
  }
  const page = await signedIn(world, "instructor", "/live");
  await eventually(async () => assert.equal(await page.locator(".live-card").count(), 40));
  // Every one had its turn.
  const cut = page.getByText(/^Cut so far: /);
  await cut.nth(39).waitFor({ timeout: 180_000 });
  const session = await page.context().newCDPSession(page);
  let bytes = 0;
  session.on("Network.dataReceived", ({ dataLength, encodedDataLength }) => {
    bytes += encodedDataLength || dataLength;
  });
  session.on("Network.responseReceived", ({ response }) => {
    bytes += response.encodedDataLength;
  });
  await session.send("Network.enable");
  // Of the page's thread alone: other programs take none of it.
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const script = async () =>
    (await session.send("Performance.getMetrics")).metrics.find(({ name }) => name === "ScriptDuration").value;
  const before = await script();
  await page.waitForTimeout(1000 * kWallSeconds);
  const kbit = (8 * bytes) / 1000 / kWallSeconds;
  const share = (100 * ((await script()) - before)) / kWallSeconds;
  console.log(`forty stations: ${kbit.toFixed(0)} kbit/s, script ${share.toFixed(1)} % of a core`);
  assert.ok(kbit <= 1000, `${kbit} kbit/s`);
}

async function withdrawReference(world) {
  const page = await signedIn(world, "instructor", `/exercises/${id(20)}`);
  await page.getByRole("button", { name: "Withdraw… version 1" }).click();
  await page.getByRole("button", { name: "Withdraw", exact: true }).click();
  await page.locator(".badge", { hasText: "Withdrawn" }).waitFor();
  assert.ok(world.mock.references[0].withdrawn_ms > 0);
}

async function progress(world) {
  const page = await signedIn(world, "student", `/exercises/${id(20)}`);
  const card = page.getByRole("region", { name: "Your progress" });
  await card.getByText("Next: Mesial wall").waitFor();
  await eventually(async () => assert.match(await card.innerText(), /cost you 10\.1 points in your attempt/));
  await eventually(async () =>
    assert.match(await card.getByRole("row", { name: /Mesial wall/ }).innerText(), /4\.9 \/ 15/),
  );
  await eventually(async () =>
    assert.match(
      await card.getByRole("img", { name: /^Mesial wall/ }).getAttribute("aria-label"),
      /33 % of the points/,
    ),
  );
  await accessible(page, "a student's progress");
  await world.picture(page, "progress", { fullPage: true });
  // The same where work is waiting, with the way to the attempt.
  await page.goto("/");
  const work = page.locator("article", { hasText: "Occlusal cavity, practice" });
  await work.getByText("Work on next: Mesial wall").waitFor();
  await eventually(async () => assert.match(await work.locator(".my-scores").innerText(), /Last\s+80\.0/));
  await accessible(page, "my work");
  await world.picture(page, "my_work");
  await work.getByRole("link", { name: "80.0" }).click();
  await page.locator(".score-card").waitFor();
}

async function print(world) {
  const page = await signedIn(world, "student", `/attempts/${id(120)}`, { width: 800, height: 1100 });
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".annotations").waitFor();
  await page.evaluate(() => {
    window.print = () => document.body.setAttribute("data-printed", "");
  });
  await page.getByRole("button", { name: "Print", exact: true }).click();
  await page.locator("body[data-printed]").waitFor();
  await page.emulateMedia({ media: "print" });
  const sides = page.locator(".set-sides img");
  assert.equal(await sides.count(), 5);
  const shown = await sides.evaluateAll((all) => all.map(({ src, naturalWidth }) => [src, naturalWidth]));
  assert.equal(new Set(shown.map(([src]) => src)).size, 5, "five different pictures");
  assert.ok(shown.every(([, width]) => width > 300));
  for (const seen of [
    "Material: Amalgam",
    "Mesial wall",
    "The mesial wall was cut 0.301 mm too far",
    "3fa9c1d2".repeat(8),
  ])
    assert.ok(await page.getByText(seen).first().isVisible(), seen);
  for (const hidden of [".header", ".tooth-tools", ".print-button", ".timeline"])
    assert.equal(await page.locator(hidden).first().isVisible(), false, hidden);
  assert.ok(await page.getByTestId("score").isVisible());
  assert.ok(await page.getByText("Too deep at this point.").isVisible());
  await world.picture(page, "printed", { fullPage: true });
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  await sides.first().waitFor({ state: "detached" });
}
