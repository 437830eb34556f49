// What an admin does.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { drawReport } from "../../web/scripts/draw_report.mjs";
import { accessible, chooseFile, golden, downloaded, looks, signedIn, signIn } from "./session.mjs";

const kConfirmFirst = {
  status: 403,
  json: { error: { code: "confirm_password", message: "Give your password again.", field: "" } },
};

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
  { name: "a cohort gets and loses members, and its grades are saved as a file", run: cohortAndGrades },
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
  const report = { format: 1, rows: [], strokes: golden("strokes"), ...golden("lab_report") };
  await (await world.as("admin")).post("/profiles/phantom_desktop/reports", report);
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
  const { newcomer } = world.school.people;
  await signIn(page, newcomer);
  await page.getByRole("heading", { level: 1, name: "Choose your own password" }).waitFor();
  await accessible(page, "the forced change of a password");
  const fill = async (old, fresh, again) => {
    await page.getByLabel("Current password").fill(old);
    await page.getByLabel("New password", { exact: true }).fill(fresh);
    await page.getByLabel("Repeat the new password").fill(again);
    await page.getByRole("button", { name: "Change password" }).click();
  };
  await fill(newcomer.password, "a new long phrase", "another long phrase");
  await page.getByText("The two passwords do not match").waitFor();
  await accessible(page, "a password that was not repeated alike");
  await fill("not the one of before", "a new long phrase", "a new long phrase");
  await page.getByRole("alert").waitFor();
  await fill(newcomer.password, "a new long phrase", "a new long phrase");
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
  await page.getByText("This PIN repeats one digit or two").waitFor();
  await pin.fill("804217");
  await page.getByRole("button", { name: "Set PIN" }).click();
  await page.getByText("Use this PIN from now on.").waitFor();
  assert.equal(await pin.inputValue(), "", "it stays on no screen");
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
  const admin = await world.as("admin");
  const path = `/people/${world.school.ids.student2}`;
  const person = () => admin.get(path);
  await admin.patch(path, { display_name: "Named by another admin" });
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
  assert.equal((await person()).display_name, "Named by me");

  await page.getByRole("button", { name: "Disable…" }).click();
  await page.getByRole("dialog").waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "detached" });
  assert.equal((await person()).disabled, false, "Escape changes nothing");
  await page.getByRole("button", { name: "Disable…" }).click();
  await page.getByRole("button", { name: "Disable", exact: true }).click();
  await page.locator(".badge", { hasText: "Disabled" }).waitFor();
  assert.equal((await person()).disabled, true);
}

async function resetPassword(world) {
  const page = await signedIn(world, "admin", `/people/${world.school.ids.student2}`);
  // As minutes after signing in; the server then asks for the password itself.
  await page.route("**/password", (route) => route.fulfill(kConfirmFirst), { times: 1 });
  await page.getByRole("button", { name: "Reset the password…" }).click();
  await page.getByRole("button", { name: "Reset the password", exact: true }).click();
  await page.getByRole("heading", { name: "Enter your password" }).waitFor();
  await accessible(page, "the question for the password");
  await page.getByLabel("Your password", { exact: true }).fill("a wrong one");
  await page.getByRole("button", { name: "Continue" }).click();
  await page.getByText("That is not your password").waitFor();
  await page.getByLabel("Your password", { exact: true }).fill(world.logins.admin.password);
  await page.getByRole("button", { name: "Continue" }).click();
  const handedOut = await page.getByRole("dialog").locator(".secret .copy-text").innerText();
  await accessible(page, "a new password");
  await world.picture(page, "one_time_password");
  await page.getByRole("button", { name: "I have noted it" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });
  assert.equal(await page.getByText(handedOut).count(), 0);
  const person = await world.open();
  await person.goto("/");
  await signIn(person, { ...world.school.people.student2, password: handedOut });
  await person.getByRole("heading", { level: 1, name: "Choose your own password" }).waitFor();
}

async function erase(world) {
  const page = await signedIn(world, "admin", `/people/${world.school.ids.class12}`);
  await page.getByRole("button", { name: "Erase this person…" }).click();
  await page.getByLabel(/^Type the login/).fill("somebody else");
  await page.getByRole("button", { name: "Erase permanently" }).click();
  await page.getByText("that is not the person's login").waitFor();
  await accessible(page, "the question before erasing");
  await page.getByLabel(/^Type the login/).fill("class12");
  await page.getByRole("button", { name: "Erase permanently" }).click();
  await page.getByRole("heading", { level: 1, name: "People" }).waitFor();
  const { people } = await (await world.as("admin")).get("/people?limit=100");
  assert.ok(people.length > 10 && people.every(({ login }) => login !== "class12"));
}

async function importRoster(world) {
  const page = await signedIn(world, "admin", "/roster");
  const admin = await world.as("admin");
  const count = async () => (await admin.get("/people?limit=100")).people.length;
  const before = await count();
  await chooseFile(
    page,
    "Roster (CSV)",
    "first.csv",
    "login,display_name,role,cohort\nnew.one,New One,studnet,A\nnew.two,=HYPERLINK(1),student,A\n",
  );
  await page.getByText("2 problems. Nothing was imported").waitFor();
  const problems = await page.getByRole("table", { name: "Problems in the roster" }).innerText();
  assert.match(problems, /2\s+role\s+"studnet"\s+student or instructor/);
  assert.match(problems, /3\s+display_name/);
  assert.equal(await page.getByRole("button", { name: /^Import/ }).count(), 0);
  await accessible(page, "a roster with problems");
  await world.picture(page, "roster_problems", { fullPage: true });
  assert.equal(await count(), before);

  await chooseFile(
    page,
    "Roster (CSV)",
    "second.csv",
    'login,display_name,role,cohort\nnew.one,New One,student,A\nnew.two,New Two,student,A\nclass12,Student Twelve,student,"Preclinic, first term"\n',
  );
  await page.getByText("2 new, 0 changed, 1 unchanged").waitFor();
  assert.equal(await count(), before, "a look changes nothing");
  await accessible(page, "a roster before its import");
  await page.getByRole("button", { name: "Import 2 people" }).click();
  await page.getByText("Passwords are shown only once").waitFor();
  await accessible(page, "an imported roster");
  const file = await downloaded(page, () => page.getByRole("button", { name: "Save 2 passwords as CSV" }).click());
  assert.match(file.text, /new\.one,New One,A,[a-z0-9]{4}(-[a-z0-9]{4})+\r\n/);
  assert.equal(await count(), before + 2);
  await page.evaluate(() => {
    window.print = () => document.body.setAttribute("data-printed", "");
  });
  await page.getByRole("button", { name: "Print 2 slips" }).click();
  await page.locator("body[data-printed] .slips").waitFor({ state: "attached" });
  await page.emulateMedia({ media: "print" });
  await page.locator(".slip", { hasText: "new.one" }).waitFor();
  assert.equal(await page.locator(".slip").count(), 2);
  assert.ok(await page.locator(".header").evaluate((header) => getComputedStyle(header).visibility !== "visible"));
  await world.picture(page, "slips");
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  await page.locator(".slips").waitFor({ state: "detached" });
}

async function search(world) {
  const page = await signedIn(world, "admin", "/people");
  await page.getByRole("link", { name: "Search" }).click();
  await page.getByLabel("Name or login").and(page.locator(":focus")).waitFor(); // its part of the page may still load
  await page.keyboard.type("student t");
  await page.getByRole("region", { name: "People" }).getByRole("link", { name: "Student Two" }).waitFor();
  const made = page.getByRole("region", { name: "Attempts" }).getByRole("link", { name: /^Student Two, / });
  await made.first().waitFor();
  await page.getByRole("region", { name: "Stations" }).getByText("Nothing found").waitFor();
  await accessible(page, "what was found");
  await world.picture(page, "search");
  await page.getByLabel("Name or login").fill("chair 2");
  await page.getByRole("region", { name: "Stations" }).getByRole("link", { name: "Chair 2" }).waitFor();
  await page.getByLabel("Name or login").fill("occlusal");
  await page
    .getByRole("region", { name: "Exercises" })
    .getByRole("link", { name: "Class I occlusal cavity" })
    .first()
    .click();
  await page.getByRole("heading", { level: 1, name: "Class I occlusal cavity" }).waitFor();
}

// What waits is seen from every page.
async function news(world) {
  // A tebibyte: more than the disks of test machines have free.
  await world.opened.restart("--min-free-mib", "1048576");
  const page = await signedIn(world, "admin", "/cohorts");
  await page
    .getByTitle(/stops? work or may lose some/)
    .filter({ hasText: "Health" })
    .waitFor();
  await page.getByTitle("1 appeal waits for an answer").filter({ hasText: "Attempts" }).waitFor();
  await page.getByRole("link", { name: "Attempts", exact: true }).waitFor(); // read as before, and then described
  await accessible(page, "what waits, in the navigation");
  await world.picture(page, "news");
  const student = await signedIn(world, "student", "/attempts");
  await student.locator("main table").waitFor();
  assert.equal(await student.locator(".nav-news").count(), 0);
}

async function cohortAndGrades(world) {
  const page = await signedIn(world, "admin", world.cohort("first"));
  const admin = await world.as("admin");
  const members = async () => (await admin.get(`/people?cohort=${world.school.cohorts.first}&limit=100`)).people;
  const before = await members();
  await page.getByLabel("Add a person: name or login").fill("newcomer");
  await page.getByRole("button", { name: "Find" }).click();
  await page.getByRole("button", { name: "Add Newcomer One" }).click();
  await page.getByRole("link", { name: "Newcomer One", exact: true }).waitFor();
  assert.equal((await members()).length, before.length + 1);

  const file = await downloaded(page, () => page.getByRole("link", { name: "Save grades as CSV" }).click());
  assert.equal(file.name, "Preclinic_first_term_grades.csv");
  const rows = file.text
    .replace(/^\uFEFF/, "")
    .trim()
    .split("\r\n");
  const students = before.filter(({ role }) => role === "student");
  assert.equal(rows.length, 1 + students.length + 1, "a row for each student");
  for (const { display_name: name } of students) assert.ok(file.text.includes(name), `${name} is in the file`);

  await page.getByRole("button", { name: "Remove… Newcomer One" }).click();
  await page.getByRole("button", { name: "Remove", exact: true }).click();
  await page.getByRole("link", { name: "Newcomer One", exact: true }).waitFor({ state: "detached" });
  assert.deepEqual(await members(), before);
}

async function stations(world) {
  const page = await signedIn(world, "admin", "/stations");
  await page.getByRole("button", { name: "Create a code" }).click();
  const command = await page.locator(".copy-text").first().innerText();
  assert.match(command, /^enamel-station enrol --server 127\.0\.0\.1:\d+ --code [0-9a-f]+@[0-9a-f]{64} --name /);
  await accessible(page, "a new enrolment code");
  await world.picture(page, "enrol");
  await page.getByRole("button", { name: "Close" }).click();
  await page.getByRole("button", { name: "Withdraw…" }).first().click();
  await page.getByRole("button", { name: "Withdraw the code" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });

  await page.getByRole("button", { name: "Rename… Chair 2" }).click();
  await page.getByLabel("Name", { exact: true }).fill("Chair 1");
  await page.getByRole("button", { name: "Rename", exact: true }).click();
  await page.getByText(/expected a name that no other station has/i).waitFor();
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
  await (await world.as("admin")).post("/listed-devices", { name: "hid:1209:0001:A7", title: "Chair 3" });
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
  await page.getByText(/coupling.*expected an integer from 1 to/).waitFor();
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
  await page.getByText("Saved as version 2 of phantom_desktop").waitFor();

  await page.getByRole("link", { name: "Phantom Desktop" }).click();
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
  await world.opened.restart("--job-threads", "0"); // what is asked for waits
  const admin = await world.as("admin");
  await (await world.as("instructor")).post(world.attempt("class5", "/rescore"), {});
  const page = await signedIn(world, "admin", "/jobs");
  await page.getByRole("button", { name: "Cancel…" }).first().click();
  await page.getByRole("button", { name: "Cancel the job" }).click();
  await page.getByRole("dialog").waitFor({ state: "detached" });
  const { jobs } = await admin.get("/jobs?state=cancelled");
  assert.equal(jobs.length, 1);
  await page.getByLabel("State").selectOption("cancelled");
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
  await page.getByRole("link", { name: "Admin One" }).first().waitFor();
  const file = await downloaded(page, () => page.getByRole("button", { name: "Save these entries as CSV" }).click());
  assert.ok(
    file.text
      .split("\r\n")
      .slice(1, -1)
      .every((row) => row.includes("person.")),
  );
}

async function auditNarrow(world) {
  const page = await signedIn(world, "admin", "/audit", { width: 390, height: 844 });
  await page
    .getByRole("cell", { name: /Instructor One released the score of attempt …[0-9a-f]{6}/ })
    .first()
    .waitFor();
  const text = await page.getByRole("main").innerText();
  assert.doesNotMatch(text, /\{\}|[0-9a-f]{8}-[0-9a-f]{4}-/, "no empty detail and no whole id");
  assert.match(text, /Released: no → yes/);
  const tab = await page.getByRole("link", { name: "Audit", exact: true }).boundingBox();
  assert.ok(tab.x >= 0 && tab.x + tab.width <= 390, `the open tab is at ${tab.x}`);
  // Of the many rows only those around the window are there.
  const rows = Number(await page.locator("main table").getAttribute("aria-rowcount")) - 1;
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  assert.ok(height / rows < 150, `${height} px for ${rows} entries`);
  await world.picture(page, "audit_narrow");
}
