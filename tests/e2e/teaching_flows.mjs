// What instructors and students do with exercises, assignments and attempts.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
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
  { name: "an assignment is ended at once, and opened again", run: endNow },
  { name: "a teacher remarks at a point of the tooth and at the tool, and the student reads it there", run: remarks },
  { name: "an attempt that was just opened is at its end for the picture, the plots and a remark", run: oneMoment },
  { name: "remarks are written by keyboard, and the focus stays there", run: remarksByKeys },
  { name: "a saved text is there in another browser, is shared, and comes back when it was removed", run: savedTexts },
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
  { name: "a student sees what each criterion cost and what to work on next", run: progress },
  { name: "a student's result prints as a document", run: print },
];

async function exerciseLife(world) {
  const teacher = await world.as("instructor");
  const document = await teacher.get(`${world.exercise("graded")}/document`);
  Object.assign(document, { name: "class-1-new", title: "A new cavity" });
  const page = await signedIn(world, "instructor", "/exercises");
  await page.getByRole("button", { name: "New exercise…" }).click();
  await page.getByText("From a document instead").click();
  await accessible(page, "adding a draft");
  await chooseFile(
    page,
    "Exercise document (JSON)",
    "new.json",
    JSON.stringify({ ...document, rubric: { ...document.rubric, prices: [] } }),
  );
  await page.getByRole("button", { name: "Add", exact: true }).click();
  await page.getByText("The document has errors").waitFor();
  await eventually(async () => assert.match(await page.getByRole("alert").innerText(), /prices\b.*expected/));
  await accessible(page, "a refused document");
  await chooseFile(page, "Exercise document (JSON)", "new.json", JSON.stringify(document));
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
  const teacher = await world.as("instructor");
  const { exercises } = await teacher.get("/exercises?limit=200");
  assert.ok(!exercises.some(({ name }) => name === "Class II"), "a grey button sends nothing");
  await dialog.getByLabel("Name").fill("class-2-second");
  await accessible(page, "copying an exercise");
  await world.picture(page, "copy_exercise");
  await make.click();
  await page.waitForURL(/\/editor\?exercise=/);
  await eventually(async () => assert.equal(await page.getByLabel("Title").first().inputValue(), "Class II, term 2"));
  const material = page.getByLabel("Restorative material");
  assert.equal(await material.inputValue(), "amalgam");
  assert.deepEqual(await material.locator("option").allInnerTexts(), ["Not named", "Amalgam", "Composite", "Ceramic"]);
  await material.selectOption({ label: "Composite" });
  await page.getByRole("button", { name: "Save the draft" }).click();
  await page.getByText(/bonding holds composite/).waitFor();
  const { rubric } = await teacher.get(`/exercises/${page.url().split("/").at(-1)}/document`);
  assert.equal(rubric.restoration, "composite");
}

async function assignmentLife(world) {
  const page = await signedIn(world, "instructor", "/assignments");
  const teacher = await world.as("instructor");
  await page.getByRole("button", { name: "Assign an exercise…" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Exercise").selectOption({ label: "Class I occlusal cavity" });
  await dialog.getByLabel("Cohort").selectOption({ label: "Preclinic, second term" });
  await dialog.getByLabel("Due").fill("2020-03-09T09:00");
  await dialog.getByText("This time has passed, so nobody could start.").waitFor();
  await dialog.getByLabel("Opens").fill("2037-03-10T09:00");
  await dialog.getByLabel("Due").fill("2037-03-09T09:00");
  await dialog.getByText("Choose a time after the assignment opens.").waitFor();
  await dialog.getByRole("checkbox", { name: "Exam" }).check();
  await dialog.getByRole("checkbox", { name: "An instructor signs at the chair" }).check();
  await dialog.getByRole("checkbox", { name: "Chair 2" }).check();
  await dialog.getByLabel("Outline on the tooth").selectOption({ label: "In practice, graded work and exams" });
  await accessible(page, "a new assignment");
  await world.picture(page, "assign");
  await dialog.getByRole("button", { name: "Assign", exact: true }).click();
  await dialog.getByText("Choose a time after the assignment opens.").waitFor();
  await dialog.getByLabel("Due").fill("2037-03-12T09:00");
  await dialog.getByRole("button", { name: "Assign", exact: true }).click();
  await page.getByRole("heading", { level: 1, name: "Class I occlusal cavity" }).waitFor();
  const path = new URL(page.url()).pathname;
  const terms = async () => {
    const { exam, sign_off, stations, outline } = await teacher.get(path);
    return [exam, sign_off, stations.length, outline];
  };
  assert.deepEqual(await terms(), [true, true, 1, "always"]);
  // Practice has no signatures.
  await page.getByRole("checkbox", { name: "Exam" }).uncheck();
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await eventually(async () => assert.deepEqual(await terms(), [false, false, 0, "always"]));
  await page.getByRole("checkbox", { name: "Exam" }).check();
  await page.getByLabel("Outline on the tooth").selectOption({ label: "Never" });
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await eventually(async () => assert.deepEqual(await terms(), [true, false, 0, "never"]));

  await teacher.put(path, (now) => ({
    exercise: now.exercise.name,
    cohort_id: now.cohort.id,
    opens_ms: now.opens_ms,
    due_ms: now.due_ms,
    exam: now.exam,
    station_ids: now.stations.map(({ id }) => id),
    attempt_limit: 7,
  }));
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
  const { assignments } = await teacher.get("/assignments?limit=200");
  assert.ok(assignments.every(({ id }) => path !== `/assignments/${id}`));

  // A newer version changes nothing until somebody moves the assignment; graded work would need a reference first.
  const admin = await world.as("admin");
  const document = await admin.get(`${world.exercise("practice")}/document`);
  const draft = await admin.post("/exercises", { ...document, time_limit_s: document.time_limit_s + 60 });
  await admin.postChanged(`/exercises/${draft.id}`, undefined, "/publish");
  await page.goto(world.assignment("practice"));
  await page.getByRole("button", { name: "Move to version 3…" }).click();
  await page.getByText(/attempts made with other versions keep their versions/).waitFor();
  await accessible(page, "moving an assignment");
  await page.getByRole("button", { name: "Move", exact: true }).click();
  await page.getByRole("link", { name: "Exercise, version 3" }).waitFor();
  assert.equal((await teacher.get(world.assignment("practice"))).exercise.id, draft.id);
  await page.goto(world.assignment("graded"));
  await page.getByRole("button", { name: "Release all scores…" }).click();
  await page.getByRole("button", { name: "Release all", exact: true }).click();
  await page.getByText(/\d+ scores released/).waitFor();
  const { attempts } = await teacher.get(`/attempts?assignment=${world.school.assignments.graded}&limit=100`);
  assert.ok(attempts.filter(({ state }) => state === "scored").every(({ released }) => released));
}

async function endNow(world) {
  const path = world.assignment("graded");
  const page = await signedIn(world, "instructor", path);
  const teacher = await world.as("instructor");
  const before = await teacher.get(path);
  await page.getByRole("button", { name: "End now" }).click();
  const ended = page.getByRole("status").filter({ hasText: "The assignment has ended." });
  await ended.waitFor();
  await accessible(page, "an assignment that has just ended");
  const after = await teacher.get(path);
  assert.ok(after.due_ms < before.due_ms && !after.late_allowed, JSON.stringify(after));
  await ended.getByRole("button", { name: "Undo" }).click();
  await page.getByRole("button", { name: "End now" }).waitFor();
  const { due_ms, late_allowed } = await teacher.get(path);
  assert.deepEqual({ due_ms, late_allowed }, { due_ms: before.due_ms, late_allowed: before.late_allowed });
}

async function remarks(world) {
  const path = world.attempt("shown");
  const page = await signedIn(world, "instructor", path);
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".annotations").waitFor();
  const box = await page.locator(".tooth-frame").boundingBox();
  await page.mouse.click(box.x + box.width * 0.3, box.y + box.height * 0.7);
  await page.getByText("At the point", { exact: false }).waitFor();
  await page.getByRole("button", { name: "Point of the new remark" }).waitFor();
  await page.getByLabel("Time in the attempt").fill("500");
  const remark = page.getByLabel(/^New remark at \d:\d\d\.\d$/);
  await remark.fill("Look at this place.");
  const [, minutes, seconds] = /(\d):(\d\d\.\d)/.exec(await page.locator(".new-remark").innerText());
  await accessible(page, "a remark being written");
  await page.getByRole("button", { name: "Add remark" }).click();
  await page.getByText("Look at this place.").waitFor();
  const teacher = await world.as("instructor");
  const { annotations } = await teacher.get(`${path}/annotations`);
  const made = annotations.find(({ text }) => text === "Look at this place.");
  assert.ok(Math.abs(made.tick / 1000 - 60 * Number(minutes) - Number(seconds)) <= 0.06, `tick ${made.tick}`);
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
  await student
    .getByRole("group", { name: "Remarks on the timeline" })
    .getByRole("button", { name: "Remark 2" })
    .click();
  await eventually(async () => assert.equal(await student.getByLabel("Time in the attempt").inputValue(), "500"));
}

async function savedTexts(world) {
  const path = world.attempt("shown");
  const at = async (role) => {
    const page = await signedIn(world, role, path);
    await page.getByLabel(/New remark/).waitFor();
    return page;
  };
  const first = await at("instructor");
  await first.getByLabel(/New remark/).fill("The floor is too dep.");
  await first.getByRole("button", { name: "Save this text" }).click();
  await first.getByText("Saved texts (1)").waitFor();

  const page = await at("instructor");
  await page.getByText("Saved texts (1)").click();
  await page.getByRole("button", { name: "Edit “The floor is too dep.”" }).click();
  await page.getByLabel("Saved text", { exact: true }).fill("The floor is too deep.");
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByRole("button", { name: "Share with all instructors: “The floor is too deep.”" }).click();
  await page.getByRole("button", { name: "Stop sharing “The floor is too deep.”" }).waitFor();
  await accessible(page, "saved texts");
  await world.picture(page, "saved_texts", { fullPage: true });

  const admin = await at("admin");
  await admin.getByText("Saved texts (1)").click();
  await admin.getByRole("button", { name: "The floor is too deep.", exact: true }).click();
  await eventually(async () =>
    assert.equal(await admin.getByLabel(/New remark/).inputValue(), "The floor is too deep."),
  );
  await admin.getByRole("button", { name: "Stop sharing “The floor is too deep.”" }).click();
  await admin.getByText("No longer shared: “The floor is too deep.”").waitFor();
  await admin.getByText("Saved texts (1)").waitFor({ state: "detached" });
  await admin.getByRole("button", { name: "Undo" }).click();
  await admin.getByText("Saved texts (1)").waitFor();

  // Changed by somebody else meanwhile: refused with the reason, then done.
  await page.getByRole("button", { name: "Remove “The floor is too deep.”" }).click();
  await page.getByRole("alert").waitFor();
  await page.getByRole("button", { name: "Remove “The floor is too deep.”" }).click();
  await page.getByText("Removed: “The floor is too deep.”").waitFor();
  await page.getByText("Saved texts (1)").waitFor({ state: "detached" });
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByText("Saved texts (1)").waitFor();
  const { texts } = await (await world.as("instructor")).get("/saved-texts");
  assert.deepEqual(
    texts.map(({ text, shared }) => ({ text, shared })),
    [{ text: "The floor is too deep.", shared: true }],
  );
}

async function oneMoment(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  await page.locator(`.playback[data-shown="${world.end.frames}"]`).waitFor();
  const slider = page.getByLabel("Time in the attempt");
  await page.locator(".plot canvas").waitFor();
  await eventually(async () => assert.equal(await page.locator(".playback-time").innerText(), world.end.text));
  await eventually(async () => assert.equal(await slider.inputValue(), await slider.getAttribute("max")));
  await eventually(async () => assert.ok((await page.locator(".readout").innerText()).includes(world.end.text)));
  const [cursor, plot] = [
    await page.locator(".plot-cursor").first().boundingBox(),
    await page.locator(".force-card .u-over").boundingBox(),
  ];
  assert.ok(
    Math.abs(cursor.x + cursor.width / 2 - plot.x - plot.width) < 2,
    `the plot's cursor is at ${cursor.x} of ${plot.x + plot.width}`,
  );
  await page.getByLabel(`New remark at ${world.end.text}`).fill("The floor is even.");
  await world.picture(page, "one_moment", { fullPage: true });
  await page.getByRole("button", { name: "Add remark" }).click();
  await page.getByRole("button", { name: new RegExp(`Remark \\d: show ${world.end.text}`) }).waitFor();
  const { annotations } = await (await world.as("instructor")).get(world.attempt("shown", "/annotations"));
  assert.ok(annotations.some(({ tick, text }) => tick === world.school.shown_ms && text === "The floor is even."));
}

const focusIsInRemark = (page) => page.waitForFunction(() => document.activeElement?.matches(".new-remark textarea"));

// Writing, the next mark and another remark, without the mouse.
async function remarksByKeys(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  await page.locator(`.playback[data-shown="${world.end.frames}"]`).waitFor();
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
  const { score } = await (await world.as("instructor")).get(world.attempt("released"));
  const computed = score.toFixed(1);
  const page = await signedIn(world, "instructor", world.attempt("released"));
  await page.getByRole("button", { name: "Override score…" }).click();
  const field = page.getByLabel("New score, 0 to 100");
  await eventually(async () => assert.equal(Number(await field.inputValue()), Number(computed)));
  assert.equal(await field.evaluate((input) => input.checkValidity()), true, "what the field begins with may be sent");
  await field.fill("88.5");
  await page.getByLabel("Reason").fill("The lesion reached the mesial wall.");
  await accessible(page, "setting a score");
  await page.getByRole("button", { name: "Set this score" }).click();
  await page.getByText(`Set by Instructor One: 88.5 instead of ${computed}`).waitFor();
  await page.getByTestId("score").filter({ hasText: "88.5" }).waitFor();
  await accessible(page, "a set score");
  await world.picture(page, "override", { fullPage: true });
  const student = await signedIn(world, "student", world.attempt("released"));
  await student.getByText("The lesion reached the mesial wall.").waitFor();
  await page.getByRole("button", { name: "Remove override…" }).click();
  await page.getByRole("button", { name: "Remove override", exact: true }).click();
  await page.getByText("The computed score counts again.").first().waitFor();
  await page.getByTestId("score").filter({ hasText: computed }).waitFor();
}

async function overrideConflict(world) {
  const admin = await world.as("admin");
  const { score } = await admin.get(world.attempt("released"));
  const page = await signedIn(world, "instructor", world.attempt("released"));
  await page.getByRole("button", { name: "Override score…" }).click();
  await page.getByLabel("New score, 0 to 100").fill("88.5");
  await page.getByLabel("Reason").fill("The lesion reached the mesial wall.");
  await admin.put(world.attempt("released"), { score: 60, reason: "The bur was worn." }, "/override");
  await page.getByRole("button", { name: "Set this score" }).click();
  const both = page.getByRole("table", { name: "Differences" });
  await both.getByRole("row", { name: /60\.0.*88\.5/ }).waitFor();
  await both.getByRole("row", { name: /The bur was worn.*The lesion reached/ }).waitFor();
  await accessible(page, "two set scores");
  await page.getByRole("button", { name: "Save my version" }).click();
  await page.getByText(`Set by Instructor One: 88.5 instead of ${score.toFixed(1)}`).waitFor();
}

async function rescoreToItsEnd(world) {
  await world.opened.restart("--job-threads", "0"); // what is asked for waits
  const page = await signedIn(world, "instructor", world.attempt("released"));
  await page.getByRole("button", { name: "Rescore…" }).click();
  await page.getByRole("button", { name: "Rescore", exact: true }).click();
  await page.getByText("Waiting to be rescored.").waitFor();
  await world.opened.restart();
  await page.getByText("The attempt was rescored.").waitFor();
  assert.equal(await page.getByText("Waiting to be rescored.").count(), 0);
  await page.getByTestId("score").waitFor();
}

async function appeal(world) {
  const path = world.attempt("released");
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
  // Until all of it is there the card moves, and a press may miss its button.
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByRole("heading", { name: "Compared with 2 dentists" }).waitFor();
  await page.getByLabel("Your answer").fill("We replay it.");
  await page.getByRole("button", { name: "Answer and rescore" }).click();
  await page.locator(".badge", { hasText: "Rescored" }).waitFor();
  await page.getByRole("region", { name: "Scored more than once" }).waitFor();
  await accessible(page, "an answered appeal");
}

async function stoppedEarly(world) {
  const page = await signedIn(world, "instructor", world.attempt("class8"));
  await page.locator(".byline", { hasText: /Stopped early: [\d.]+ % done/ }).waitFor();
  await page.getByText(/Nothing of the task was cut/).waitFor();
}

async function live(world) {
  const { graded, practice } = { graded: "class-1-molar-46", practice: "practice-class-1-molar-46" };
  const { opened, school } = world;
  const first = opened.attempt("Chair 1", "student", practice, "dentist", "--assignment", school.assignments.practice);
  opened.attempt("Chair 2", "student2", graded, "dentist", "--assignment", school.assignments.graded);
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
  await page.locator(".live-card .badge.good").nth(1).waitFor();
  await eventually(async () => assert.equal(await page.locator(".live-card").count(), 2));
  await page.waitForFunction(() =>
    [...document.querySelectorAll(".live-force b")].every((force) => /\sN$/.test(force.textContent)),
  );
  await page
    .getByText(/\d+\smin\s\d\d\ss left of 15\smin/)
    .first()
    .waitFor();
  // The tooth of each is under the tool.
  await page
    .getByRole("img", { name: /^Tool from above: .*of the crown’s middle$/ })
    .nth(1)
    .waitFor();
  await page
    .getByText(/^Cut so far: up to [\d.]+\smm deep$/)
    .nth(1)
    .waitFor();
  await world.picture(page, "live", { fullPage: true });
  await page.getByRole("link", { name: "Chair 1" }).click();
  await page.getByText("Largest in 20 s").waitFor();
  await page.getByText(/^Cut so far: up to [\d.]*[1-9][\d.]*\smm deep$/).waitFor();
  await eventually(async () =>
    assert.match(
      await page.getByRole("img", { name: /^Force over the last/ }).getAttribute("aria-label"),
      /at most [\d.]+ N/,
    ),
  );
  await accessible(page, "a watched attempt");
  await opened.handIn("Chair 1", first);
  await page.getByText("This attempt is finished").waitFor();
}

const kWallSeconds = 20;

async function fortyLive(world) {
  world.opened.stream(40, 5);
  const page = await signedIn(world, "admin", "/live");
  await eventually(async () => assert.equal(await page.locator(".live-card").count(), 40));
  // Every one had its turn.
  await page
    .getByText(/^Cut so far: /)
    .nth(39)
    .waitFor({ timeout: 180_000 });
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
  assert.ok(kbit > 0 && kbit <= 1000, `${kbit} kbit/s`);
}

async function withdrawReference(world) {
  const page = await signedIn(world, "instructor", world.exercise("graded"));
  await page.getByRole("button", { name: "Withdraw… version 1" }).click();
  await page.getByRole("button", { name: "Withdraw", exact: true }).click();
  await page.locator(".badge", { hasText: "Withdrawn" }).waitFor();
  const { references } = await (await world.as("instructor")).get(`${world.exercise("graded")}/references`);
  assert.ok(references.find(({ version }) => version === 1).withdrawn_ms > 0);
}

async function progress(world) {
  const page = await signedIn(world, "student", world.exercise("practice"));
  const card = page.getByRole("region", { name: "Your progress" });
  await card.getByText(/^Mesial wall: over-extended by/).waitFor();
  await eventually(async () => assert.match(await card.innerText(), /cost you [\d.]+ points in your attempt/));
  await eventually(async () => assert.match(await card.getByRole("row", { name: /Outline/ }).innerText(), /−\d+\.\d/));
  await eventually(async () =>
    assert.match(await card.getByRole("img", { name: /^Outline/ }).getAttribute("aria-label"), /points lost \d/),
  );
  await accessible(page, "a student's progress");
  await world.picture(page, "progress", { fullPage: true });
  // The same where work is waiting, with the way to the attempt.
  await page.goto("/");
  const work = page.locator("article", { hasText: "Work on this next" }).first();
  const shown = async () => /Last\s+(\d+\.\d)/.exec(await work.locator(".my-scores").innerText())?.[1];
  await eventually(async () => assert.ok(await shown()));
  const last = await shown();
  await accessible(page, "my work");
  await world.picture(page, "my_work");
  await work.getByRole("link", { name: last }).click();
  await page.locator(".score-card").waitFor();
  await eventually(async () =>
    assert.equal(Number.parseFloat(await page.getByTestId("score").innerText()), Number(last)),
  );
}

async function print(world) {
  const page = await signedIn(world, "student", world.attempt("released"), { width: 800, height: 1100 });
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
  assert.match(await page.locator(".fingerprint").innerText(), /^[0-9a-f]{64}$/);
  for (const seen of ["Material: Amalgam", "Mesial wall"])
    assert.ok(await page.getByText(seen).first().isVisible(), seen);
  for (const hidden of [".header", ".tooth-tools", ".print-button", ".timeline"])
    assert.equal(await page.locator(hidden).first().isVisible(), false, hidden);
  assert.ok(await page.getByTestId("score").isVisible());
  assert.ok(await page.getByText("Too deep at this point.").isVisible());
  await world.picture(page, "printed", { fullPage: true });
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  await sides.first().waitFor({ state: "detached" });
}
