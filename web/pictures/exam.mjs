// exam.mjs PAGE_URL FOLDER PASSWORD: walks the steps of docs/first_exam.md on an empty server, as its admin `head`, whose
// one-time password is PASSWORD, and draws FOLDER/pictures/exam_*.png. A step that the page refuses ends it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { begin, eventually, launch, newPage } from "../../tests/e2e/browser.mjs";
import { toothAtRest } from "../../tests/e2e/pixels.mjs";
import { program } from "../../tests/e2e/school/programs.mjs";
import { signIn } from "../../tests/e2e/session.mjs";

const [url, folder, firstPassword] = process.argv.slice(2);
const kCohort = "Year 3";
const kExercise = "class-1-molar-46";
const kRoster = readFileSync(new URL("../../schemas/golden/roster.csv", import.meta.url));
const kTeacher = { login: "c.osei", name: "Dr. Chidi Osei" };
// Each hand's own skill, and a seed of its mistakes.
const kStudents = [
  { login: "a.meyer", hand: "good", seed: 31 },
  { login: "b.vega", hand: "first-year", seed: 6 },
];
const kSize = { width: 1040, height: 880 };
const kCutMs = 900_000;

const browser = await launch();
const button = (page, name) => page.getByRole("button", { name, exact: true });
const pathOf = (name) => join(folder, "pictures", `exam_${name}.png`);
const own = ({ login }) => `five plain words of ${login}`;

// The page from its top to the end of what it shows, at most a window of it.
async function picture(page, name) {
  await page.evaluate(() => scrollTo(0, 0));
  const ends = await page.locator("main").evaluate((main) => main.lastElementChild.getBoundingClientRect().bottom);
  const height = Math.min(kSize.height, Math.ceil(ends) + 20);
  await page.screenshot({ path: pathOf(name), clip: { x: 0, y: 0, width: page.viewportSize().width, height } });
}

// A browser of somebody who signs in with a one-time password and chooses their own.
async function arrived(person, password) {
  const page = await newPage(browser, url);
  await begin(page, kSize);
  await page.goto("/");
  await signIn(page, { login: person.login, password });
  await page.getByLabel("Current password").fill(password);
  await page.getByLabel("New password", { exact: true }).fill(own(person));
  await page.getByLabel("Repeat the new password").fill(own(person));
  await button(page, "Change password").click();
  await page.getByRole("navigation").first().waitFor();
  return page;
}

// The page of an attempt with all that the server makes of it.
async function whole(page) {
  await page.reload();
  await page.locator(".playback").waitFor();
  await page.locator(".plot canvas").waitFor();
  await toothAtRest(page);
}

// An attempt of a simulated hand at a chair; its id.
async function cut(chair, person, hand, ...more) {
  const facts = join(folder, `${chair}.json`);
  const args = ["run", "--data", join(folder, chair), "--exercise", kExercise, "--profile", "phantom_desktop"];
  args.push("--user", person.login, "--operator", hand, "--json", facts, "--quiet", ...more);
  await program("enamel-station", args, { environment: { ENAMEL_PASSWORD: own(person) }, mostMs: kCutMs });
  return JSON.parse(readFileSync(facts, "utf8")).attempt_id;
}

try {
  // 1 and 2: the admin's own password, then the roster.
  const head = await arrived({ login: "head" }, firstPassword);
  await head.goto("/roster");
  await head.getByLabel("Roster (CSV)").setInputFiles({
    name: "year3.csv",
    mimeType: "text/csv",
    buffer: kRoster,
  });
  const carryOut = head.getByRole("button", { name: /^Import \d+ people/ });
  await carryOut.waitFor();
  await head
    .locator("main .card")
    .last()
    .screenshot({ path: pathOf("roster") });
  await carryOut.click();
  const given = new Map();
  await head.getByText("Passwords are shown only once").waitFor();
  for (const row of await head.locator("table tbody tr").all()) {
    const [, login, password] = await row.locator("th, td").allInnerTexts();
    given.set(login.trim(), password.trim());
  }

  // 3: a tooth with its exercises.
  await head.goto("/exercises?import=tooth");
  await head.getByLabel("Built-in tooth").selectOption("molar");
  await button(head, "Add it").click();
  await head.getByText(/exercises? published/).waitFor();
  await head.getByRole("dialog").screenshot({ path: pathOf("tooth") });

  // 4: two chairs, and the haptic device of one.
  for (const [i, { login }] of kStudents.entries()) {
    await head.goto("/stations");
    await button(head, "Create a code").click();
    const command = await head.getByRole("dialog").innerText();
    const [, server, code] = command.match(/--server (\S+) --code (\S+)/);
    const chair = ["--data", join(folder, login), "--name", `Chair ${i + 1}`];
    await program("enamel-station", ["enrol", "--server", server, "--code", code, ...chair]);
  }
  await head.goto("/stations");
  await button(head, "Add a device…").click();
  await head.getByRole("dialog").getByLabel("Device ID").fill("hid:1209:0001:A7");
  await head.getByRole("dialog").getByLabel("Name").fill("Chair 1");
  await head.getByRole("dialog").getByRole("button", { name: "Add", exact: true }).click();
  await head.getByRole("table", { name: "Devices for graded work" }).waitFor();

  // 5 and 6: the reference.
  const teacher = await arrived(kTeacher, given.get(kTeacher.login));
  const reference = await cut(kStudents[0].login, kTeacher, "dentist", "--as-reference", "--lockstep");
  await teacher.goto(`/attempts/${reference}`);
  await button(teacher, "Mark as reference…").waitFor(); // once it has its score
  await whole(teacher);
  await button(teacher, "Mark as reference…").click();
  await teacher.getByLabel("Dentist who made this cut").fill(kTeacher.name);
  await teacher.getByLabel("The dentist agrees to be named").check();
  await picture(teacher, "reference");
  await button(teacher, "Mark as reference").click();
  await teacher.getByText("The attempt is now a reference").waitFor();

  // 7: the exam.
  await teacher.goto("/assignments");
  await button(teacher, "Assign an exercise…").click();
  const dialog = teacher.getByRole("dialog");
  await dialog.getByLabel("Exercise").selectOption(kExercise);
  await dialog.getByLabel("Cohort").selectOption({ label: kCohort });
  await dialog.getByLabel("Attempts per student").fill("1");
  await dialog.getByRole("checkbox", { name: "Exam", exact: true }).check();
  await dialog.screenshot({ path: pathOf("assign") });
  await dialog.getByLabel("Devices allowed").selectOption("any"); // the hands are simulated
  await button(dialog, "Assign").click();
  await teacher.waitForURL(/\/assignments\/./);
  const assignment = teacher.url();

  // 8: two students at two chairs.
  await Promise.all(kStudents.map((student) => arrived(student, given.get(student.login))));
  const cuts = kStudents.map((each) => cut(each.login, each, each.hand, "--seed", String(each.seed)));
  await teacher.goto("/live");
  await eventually(async () => {
    assert.equal(await teacher.getByText(/up to [1-9].* deep/).count(), kStudents.length);
  });
  await picture(teacher, "live");
  const attempts = await Promise.all(cuts);

  // 9: grading.
  await teacher.goto(assignment.replace("/assignments/", "/grading?assignment="));
  await eventually(async () => {
    await teacher.reload();
    await teacher.locator("table").waitFor();
    assert.equal(await teacher.getByText("To release", { exact: true }).count(), kStudents.length);
  });
  await teacher.setViewportSize({ ...kSize, width: 1600 }); // all criteria beside each other
  await picture(teacher, "grading");
  await teacher.setViewportSize(kSize);
  await teacher.goto(`/attempts/${attempts.at(-1)}`);
  await whole(teacher);
  await picture(teacher, "attempt");

  // 10: release.
  await teacher.goto(assignment);
  await button(teacher, "Release all scores…").click();
  await button(teacher, "Release all").click();
  await teacher.getByRole("dialog").waitFor({ state: "hidden" });
  await teacher.goto("/cohorts");
  await teacher.getByRole("link", { name: kCohort, exact: true }).click();
  await teacher.getByText("Save grades as CSV").waitFor();
  await picture(teacher, "grades");
} finally {
  await browser.close();
}
