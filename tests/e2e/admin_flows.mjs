// What an admin does, against the mock server.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { drawReport } from "../../web/scripts/draw_report.mjs";
import { golden } from "./contract.mjs";
import { id } from "./mock_exercises.mjs";
import { accessible, chooseFile, downloaded, looks, signedIn, signIn } from "./session.mjs";

const kLongAgo = -600_000;

export const adminFlows = [
  { name: "an admin finds people, attempts, exercises and stations by name", run: search },
  { name: "appeals that wait and trouble of the server are seen in the navigation", run: news },
  { name: "a one-time password has to be changed before anything else", run: forcedPassword },
  { name: "own sessions are listed and ended", run: ownSessions },
  { name: "an instructor sets a PIN for exams, and a student is asked for none", run: choosePin },
  { name: "an admin finds, edits and disables a person, and a conflict shows both values", run: editPerson },
  { name: "a password is reset after the admin's own was given again, and shown once", run: resetPassword },
  { name: "a person is erased only when the login is repeated", run: erase },
  { name: "a roster with problems changes nothing, a right one is imported after a look", run: importRoster },
  { name: "a cohort gets and loses members, and its grades are saved without a formula in them", run: cohortAndGrades },
  { name: "a station is enrolled by a code, renamed and revoked", run: stations },
  { name: "a device is listed for graded work and taken off again", run: listedDevices },
  { name: "a device profile is judged by its criteria, and a calibration is added", run: profiles },
  { name: "what a hand can feel fits narrow and wide screens, dark and light", run: feltNarrowAndDark },
  { name: "a report's strokes are drawn, opened by their address and closed", run: drawnReport },
  { name: "a report's strokes as one file need nothing else", run: reportAsOneFile },
  { name: "a job is cancelled, and the audit is narrowed", run: jobsAndAudit },
  { name: "the audit reads in sentences, also on a narrow screen with its tab in view", run: auditNarrow },
];

async function drawnReport(world) {
  const page = await signedIn(world, "admin", "/profiles/phantom_desktop");
  const draw = page.getByRole("button", { name: /^Draw the report/ });
  await draw.click();
  const card = page.getByRole("region", { name: "Force over time" });
  const press = card.getByRole("region", { name: "Press", exact: true });
  await press
    .getByRole("img", { name: /^Press: force over/ })
    .locator("canvas")
    .waitFor();
  await press.getByText("Figures, and positions of tip and bur").click();
  await eventually(async () =>
    assert.ok((await press.getByRole("group", { name: "Press: figures" }).locator("tbody tr").count()) >= 4),
  );
  // What else was found is drawn below: a share of cases, a map of verdicts, a table.
  for (const name of [/^Share of hands below a difference from plain Maxwell/, /^Map\. delay, ticks against B/]) {
    await page.getByRole("img", { name }).locator("canvas").waitFor();
  }
  await page.getByRole("group", { name: "Adversary: games" }).getByText("UNDER 1 nJ").waitFor();
  await page.reload();
  await press.waitFor();
  await eventually(async () => assert.equal(await draw.getAttribute("aria-pressed"), "true"));
  await card.getByRole("button", { name: "Close" }).click();
  assert.equal(await card.count(), 0);
  assert.equal(new URL(page.url()).search, "");
}

// What draw_report.mjs makes runs from a file, under its own policy, and asks nobody for anything.
async function reportAsOneFile(world) {
  const file = join(mkdtempSync(join(tmpdir(), "enamel-report-")), "strokes.html");
  await drawReport(fileURLToPath(new URL("../../schemas/golden/strokes.json", import.meta.url)), file);
  const page = await world.open();
  const asked = [];
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(pathToFileURL(file).href);
  await page
    .getByRole("img", { name: /^Press: force over/ })
    .locator("canvas")
    .waitFor();
  await accessible(page, "the report as one file");
  assert.deepEqual(asked, [pathToFileURL(file).href]);
}

async function forcedPassword(world) {
  const page = await world.open();
  await page.goto("/attempts");
  await signIn(
    page,
    world.mock.people.find((person) => person.login === "newcomer"),
  );
  await page.getByRole("heading", { level: 1, name: "Choose your own password" }).waitFor();
  await accessible(page, "the forced change of a password");
  const fill = async (old, fresh, again) => {
    await page.getByLabel("Current password").fill(old);
    await page.getByLabel("New password", { exact: true }).fill(fresh);
    await page.getByLabel("Repeat the new password").fill(again);
    await page.getByRole("button", { name: "Change password" }).click();
  };
  await fill("given by the office", "a new long phrase", "another long phrase");
  await page.getByText("The two passwords do not match").waitFor();
  await accessible(page, "a password that was not repeated alike");
  await fill("not the one of before", "a new long phrase", "a new long phrase");
  await page.getByRole("alert").waitFor();
  await fill("given by the office", "a new long phrase", "a new long phrase");
  await page.getByRole("heading", { level: 1, name: "My attempts" }).waitFor();
  // The first request that changes something in the new session.
  await page.getByRole("button", { name: "Sign out" }).click();
  await page.getByRole("heading", { level: 1, name: "Sign in" }).waitFor();
}

async function ownSessions(world) {
  const page = await signedIn(world, "student", "/account");
  await signedIn(world, "student");
  await page.reload();
  const table = page.getByRole("table", { name: "Your sessions" });
  await table.getByRole("button", { name: "End…" }).first().click();
  await accessible(page, "a question before something is ended");
  await page.getByRole("button", { name: "End session" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });
  await table.getByRole("row").nth(2).waitFor({ state: "detached" });
  await page.getByText("This session").first().waitFor();
}

async function choosePin(world) {
  const page = await signedIn(world, "instructor", "/account");
  const pin = page.getByLabel("New PIN");
  await pin.fill("111111");
  await page.getByRole("button", { name: "Set PIN" }).click();
  await page.getByText("not all the same and not in a row").waitFor();
  await pin.fill("804217");
  await page.getByRole("button", { name: "Set PIN" }).click();
  await page.getByText("Use this PIN from now on.").waitFor();
  assert.equal(await pin.inputValue(), "", "it stays on no screen");
  assert.equal(world.mock.people.find(({ role }) => role === "instructor").pin, "804217");
  await accessible(page, "the form of a PIN");
  const student = await signedIn(world, "student", "/account");
  await student.getByLabel("Current password").waitFor();
  assert.equal(await student.getByLabel("New PIN").count(), 0);
}

async function editPerson(world) {
  const page = await signedIn(world, "admin", "/people");
  await page.getByLabel("Name or login").fill("two");
  await page.getByRole("button", { name: "Search" }).click();
  await page.getByRole("link", { name: "Student Two" }).click();
  const name = page.getByLabel("Name", { exact: true });
  await name.fill("Student Two the Second");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText("Saved.").waitFor();

  // Somebody else changes the same person meanwhile.
  const person = world.mock.people.find((item) => item.login === "student2");
  Object.assign(person, { display_name: "Named by another admin", revision: person.revision + 1 });
  await name.fill("Named by me");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText("Somebody else has changed this").waitFor();
  const differs = await page.getByRole("table", { name: "Differences" }).innerText();
  assert.match(differs, /Named by another admin/);
  assert.match(differs, /Named by me/);
  await accessible(page, "a conflict");
  await world.picture(page, "conflict", { fullPage: true });
  await page.getByRole("button", { name: "Save my version" }).click();
  await page.getByText("Saved.").waitFor();
  assert.equal(person.display_name, "Named by me");

  await page.getByRole("button", { name: "Disable…" }).click();
  await page.getByRole("dialog").waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "detached" });
  assert.equal(person.disabled, false, "Escape changes nothing");
  await page.getByRole("button", { name: "Disable…" }).click();
  await page.getByRole("button", { name: "Disable", exact: true }).click();
  await page.locator(".badge", { hasText: "Disabled" }).waitFor();
  assert.equal(person.disabled, true);
}

async function resetPassword(world) {
  const page = await signedIn(world, "admin", `/people/${id(2)}`);
  for (const session of world.mock.sessions) session.confirmedMs = world.mock.nowMs + kLongAgo;
  await page.getByRole("button", { name: "Reset the password…" }).click();
  await page.getByRole("button", { name: "Reset the password", exact: true }).click();
  await page.getByRole("heading", { name: "Enter your password" }).waitFor();
  await accessible(page, "the question for the password");
  await page.getByLabel("Your password", { exact: true }).fill("a wrong one");
  await page.getByRole("button", { name: "Continue" }).click();
  await page.getByText("That is not your password").waitFor();
  await page.getByLabel("Your password", { exact: true }).fill(world.logins.admin.password);
  await page.getByRole("button", { name: "Continue" }).click();
  await page.getByText("amber kettle north").waitFor();
  await accessible(page, "a new password");
  await world.picture(page, "one_time_password");
  await page.getByRole("button", { name: "I have noted it" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });
  assert.equal(await page.getByText("amber kettle north").count(), 0);
}

async function erase(world) {
  const page = await signedIn(world, "admin", `/people/${id(1002)}`);
  await page.getByRole("button", { name: "Erase this person…" }).click();
  await page.getByLabel(/^Type the login/).fill("somebody else");
  await page.getByRole("button", { name: "Erase permanently" }).click();
  await page.getByText("that is not the person's login").waitFor();
  await accessible(page, "the question before erasing");
  await page.getByLabel(/^Type the login/).fill("student5");
  await page.getByRole("button", { name: "Erase permanently" }).click();
  await page.getByRole("heading", { level: 1, name: "People" }).waitFor();
  assert.ok(world.mock.people.every((person) => person.login !== "student5"));
}

async function importRoster(world) {
  const page = await signedIn(world, "admin", "/roster");
  const before = world.mock.people.length;
  await chooseFile(
    page,
    "Roster (CSV)",
    "first.csv",
    "login,display_name,role,cohort\nnew.one,New One,studnet,A\nnew.two,=HYPERLINK(1),student,A\n",
  );
  await page.getByText("2 problems. Nothing was imported").waitFor();
  const problems = await page.getByRole("table", { name: "Problems in the roster" }).innerText();
  assert.match(problems, /2\s+role\s+studnet\s+student, instructor or admin/);
  assert.match(problems, /3\s+display_name/);
  assert.equal(await page.getByRole("button", { name: /^Import/ }).count(), 0);
  await accessible(page, "a roster with problems");
  await world.picture(page, "roster_problems", { fullPage: true });
  assert.equal(world.mock.people.length, before);

  await chooseFile(
    page,
    "Roster (CSV)",
    "second.csv",
    "login,display_name,role,cohort\nnew.one,New One,student,A\nnew.two,-New Two,student,A\nstudent,Student One,student,A\n".replace(
      "-New",
      "New",
    ),
  );
  await page.getByText("2 new, 0 changed, 1 unchanged").waitFor();
  assert.equal(world.mock.people.length, before, "a look changes nothing");
  await accessible(page, "a roster before its import");
  await page.getByRole("button", { name: "Import 2 people" }).click();
  await page.getByText("Passwords are shown only once").waitFor();
  await accessible(page, "an imported roster");
  const file = await downloaded(page, () => page.getByRole("button", { name: "Save 2 passwords as CSV" }).click());
  assert.match(file.text, /new\.one,New One,A,copper lantern 1\r\n/);
  assert.equal(world.mock.people.length, before + 2);
  await page.evaluate(() => {
    window.print = () => document.body.setAttribute("data-printed", "");
  });
  await page.getByRole("button", { name: "Print 2 slips" }).click();
  await page.locator("body[data-printed] .slips").waitFor({ state: "attached" });
  await page.emulateMedia({ media: "print" });
  await page.locator(".slip", { hasText: "copper lantern 1" }).waitFor();
  assert.equal(await page.locator(".slip").count(), 2);
  assert.ok(await page.locator(".header").evaluate((header) => getComputedStyle(header).visibility !== "visible"));
  await world.picture(page, "slips");
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  await page.locator(".slips").waitFor({ state: "detached" });
}

async function search(world) {
  const page = await signedIn(world, "admin", "/people");
  await page.getByRole("link", { name: "Search" }).click();
  await page.keyboard.type("student t");
  await page.getByRole("region", { name: "People" }).getByRole("link", { name: "Student Two" }).waitFor();
  const made = page.getByRole("region", { name: "Attempts" }).getByRole("link", { name: /^Student Two, / });
  await made.first().waitFor();
  await page.getByRole("region", { name: "Stations" }).getByText("Nothing found").waitFor();
  await accessible(page, "what was found");
  await world.picture(page, "search");
  await page.getByLabel("Name or login").fill("station 3");
  await page.getByRole("region", { name: "Stations" }).getByRole("link", { name: "Station 3" }).waitFor();
  await page.getByLabel("Name or login").fill("occlusal");
  await page
    .getByRole("region", { name: "Exercises" })
    .getByRole("link", { name: "Occlusal cavity, class I" })
    .first()
    .click();
  await page.getByRole("heading", { level: 1, name: "Occlusal cavity, class I" }).waitFor();
}

// What waits is seen from every page.
async function news(world) {
  world.mock.trouble = {
    ingest: { takes_recordings: false, problem: "the disk is full", waiting: "", chunks: 0, chunk_bytes: 0, sealed: 0 },
  };
  const page = await signedIn(world, "admin", "/cohorts");
  await page.getByTitle("1 thing stops work or may lose some").filter({ hasText: "Health" }).waitFor();
  await page.getByTitle("1 appeal waits for an answer").filter({ hasText: "Attempts" }).waitFor();
  await page.getByRole("link", { name: "Attempts", exact: true }).waitFor(); // read as before, and then described
  await accessible(page, "what waits, in the navigation");
  await world.picture(page, "news");
  const student = await signedIn(world, "student", "/attempts");
  await student.locator("main table").waitFor();
  assert.equal(await student.locator(".nav-news").count(), 0);
}

async function cohortAndGrades(world) {
  const page = await signedIn(world, "admin", `/cohorts/${id(10)}`);
  const cohort = world.mock.cohorts[0];
  const stranger = world.mock.people.find((person) => person.login === "student100");
  stranger.display_name = "=HYPERLINK(1) Hundred";
  await page.getByLabel("Add a person: name or login").fill("student100");
  await page.getByRole("button", { name: "Find" }).click();
  await page.getByRole("button", { name: "Add =HYPERLINK(1) Hundred" }).click();
  await page.getByRole("link", { name: "=HYPERLINK(1) Hundred", exact: true }).waitFor();
  assert.ok(cohort.members.includes(stranger));

  const file = await downloaded(page, () => page.getByRole("button", { name: "Save grades as CSV" }).click());
  assert.equal(file.name, "Preclinic_first_term_grades.csv");
  const rows = file.text
    .replace(/^\uFEFF/, "")
    .trim()
    .split("\r\n");
  assert.equal(rows.length, 1 + cohort.members.length - 1, "a row for each student");
  assert.ok(
    rows.some((row) => row.includes("'=HYPERLINK(1) Hundred")),
    "a name that looks like a formula is none",
  );
  assert.ok(rows.every((row) => !/(^|,)"?=/.test(row)));

  await page.getByRole("button", { name: "Remove… =HYPERLINK(1) Hundred" }).click();
  await page.getByRole("button", { name: "Remove", exact: true }).click();
  await page.getByRole("link", { name: "=HYPERLINK(1) Hundred", exact: true }).waitFor({ state: "detached" });
  assert.ok(!cohort.members.includes(stranger));
}

async function stations(world) {
  const page = await signedIn(world, "admin", "/stations");
  await page.getByRole("button", { name: "Create a code" }).click();
  const command = await page.locator(".copy-text").first().innerText();
  assert.match(command, /^enamel-station enrol --server 127\.0\.0\.1:8600 --code [0-9a-f]+@[0-9a-f]{64} --name /);
  await accessible(page, "a new enrolment code");
  await world.picture(page, "enrol");
  await page.getByRole("button", { name: "Close" }).click();
  await page.getByRole("button", { name: "Withdraw…" }).first().click();
  await page.getByRole("button", { name: "Withdraw the code" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });

  await page.getByRole("button", { name: "Rename… Station 4" }).click();
  await page.getByLabel("Name", { exact: true }).fill("Station 1");
  await page.getByRole("button", { name: "Rename", exact: true }).click();
  await page.getByText("expected one that nobody has").waitFor();
  await accessible(page, "a name that is taken");
  await page.getByLabel("Name", { exact: true }).fill("Window seat");
  await page.getByRole("button", { name: "Rename", exact: true }).click();
  await page.getByRole("rowheader", { name: "Window seat" }).waitFor();

  await page.getByRole("button", { name: "Revoke… Window seat" }).click();
  await page.getByRole("button", { name: "Revoke the station" }).click();
  await page
    .getByRole("row", { name: /Window seat/ })
    .getByText("Revoked")
    .waitFor();
}

async function listedDevices(world) {
  const page = await signedIn(world, "admin", "/stations");
  await page.getByRole("button", { name: "Add a device…" }).click();
  await page.getByLabel("Device ID").fill("hid:1209:0001:B2");
  await page.getByLabel("Name", { exact: true }).fill("Chair 9");
  await accessible(page, "a device for graded work");
  await world.picture(page, "device");
  await page.getByRole("button", { name: "Add", exact: true }).click();
  await page.getByRole("rowheader", { name: "Chair 9" }).waitFor();
  await page.getByRole("button", { name: "Remove… Chair 3" }).click();
  await page.getByRole("button", { name: "Remove", exact: true }).click();
  await page.getByRole("rowheader", { name: "Chair 3" }).waitFor({ state: "detached" });
}

async function profiles(world) {
  const page = await signedIn(world, "admin", "/profiles");
  const label = "Profile document (JSON)";
  const save = () => page.getByRole("button", { name: "Check and save" }).click();
  const profile = golden("scene_profile_phantom_desktop");
  const coupled = (value) => JSON.stringify({ ...profile, coupling_mn_per_mm: { value, source: "measured" } });
  await chooseFile(page, label, "odd.json", coupled(0.5));
  await save();
  await page.getByText("coupling_mn_per_mm.value: expected").waitFor();
  await chooseFile(page, label, "wild.json", coupled(9000));
  await save();
  await page.getByText("would not be stable").waitFor();
  await page
    .getByRole("row", { name: /Passivity limit of the coupling/ })
    .getByText("Not met")
    .waitFor();
  await accessible(page, "a refused profile");
  await world.picture(page, "profile_refused", { fullPage: true });
  await chooseFile(page, label, "tame.json", coupled(1000));
  await save();
  await page.getByText("Saved as version 3 of phantom_desktop").waitFor();

  await page.getByRole("link", { name: "Phantom Desktop" }).click();
  await page.locator(".trend").first().waitFor();
  await whatAHandCanFeel(page);
  await chooseFile(
    page,
    "Add a calibration (JSON)",
    "c.json",
    JSON.stringify({ ...golden("scene_calibration"), device: "hid:0451:bef3 serial 7" }),
  );
  await page.getByRole("region", { name: "Calibrations" }).getByRole("button", { name: "Add", exact: true }).click();
  await page.getByRole("heading", { name: "hid:0451:bef3 serial 7" }).waitFor();
}

async function whatAHandCanFeel(page) {
  const card = page.getByRole("region", { name: "What a hand can feel" });
  // With 1 N/mm enamel passes in no grip: the row says so.
  await card
    .getByRole("table")
    .getByRole("row", { name: /Enamel/ })
    .waitFor();
  await accessible(page, "what a hand can feel");
}

async function feltNarrowAndDark(world) {
  for (const [colorScheme, width] of looks(["dark", 390], ["light", 390], ["dark", 1280], ["light", 1280])) {
    const page = await signedIn(world, "admin", "/profiles/phantom_desktop", { width, height: 844, colorScheme });
    await page.getByRole("region", { name: "What a hand can feel" }).getByRole("table").waitFor();
    await world.picture(page.getByRole("region", { name: "What a hand can feel" }), `feel_${colorScheme}_${width}`);
    assert.ok(
      await page.evaluate(() => document.documentElement.scrollWidth <= document.documentElement.clientWidth),
      `wider than ${width} px`,
    );
    await accessible(page, `what a hand can feel, ${colorScheme}, ${width} px`);
  }
}

async function jobsAndAudit(world) {
  const page = await signedIn(world, "admin", "/jobs");
  await page.getByRole("button", { name: "Cancel…" }).first().click();
  await page.getByRole("button", { name: "Cancel the job" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });
  assert.ok(world.mock.jobs.some((job) => job.state === "cancelled"));
  await page.getByLabel("State").selectOption("failed");
  await page.getByText("The volume of the scene is missing.").waitFor();
  await eventually(async () => assert.equal(await page.locator("tbody tr").count(), 1));

  await page.getByRole("link", { name: "Audit" }).click();
  await page.getByLabel("Who (login)").fill("nobody");
  await page.getByRole("button", { name: "Search" }).click();
  await page.getByText("Nobody has this login.").waitFor();
  await page.getByLabel("Who (login)").fill("admin");
  await page.getByLabel("Action").fill("person.");
  await page.getByRole("button", { name: "Search" }).click();
  await page.waitForURL(/action=person/);
  await page.getByRole("row").filter({ hasText: "released the score of" }).first().waitFor({ state: "detached" });
  await page.getByRole("link", { name: "Admin One" }).nth(1).waitFor();
  const file = await downloaded(page, () => page.getByRole("button", { name: "Save these entries as CSV" }).click());
  assert.ok(
    file.text
      .split("\r\n")
      .slice(1, -1)
      .every((row) => row.includes("person.edit")),
  );
}

async function auditNarrow(world) {
  const page = await signedIn(world, "admin", "/audit", { width: 390, height: 844 });
  await page
    .getByRole("cell", { name: /Instructor One released the score of attempt …0001\d\d/ })
    .first()
    .waitFor();
  const text = await page.getByRole("main").innerText();
  assert.doesNotMatch(text, /\{\}|[0-9a-f]{8}-[0-9a-f]{4}-/, "no empty detail and no whole id");
  assert.match(text, /Role: student → instructor/);
  const tab = await page.getByRole("link", { name: "Audit", exact: true }).boundingBox();
  assert.ok(tab.x >= 0 && tab.x + tab.width <= 390, `the open tab is at ${tab.x}`);
  const rows = await page.locator("tbody tr").count();
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  assert.ok(height / rows < 150, `${height} px for ${rows} entries`);
  await world.picture(page, "audit_narrow");
}
