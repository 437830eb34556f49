// Signing in, languages, and what each role sees first.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { accessible, signedIn, signIn } from "./session.mjs";

export const generalFlows = [
  {
    name: "the page speaks German and Chinese from the sign-in on, and who chose one finds it again",
    run: speaksLanguages,
  },
  { name: "a wrong password is refused in words and keeps the login", anywhere: true, run: wrongPassword },
  { name: "an expired session asks to sign in again and leads back", anywhere: true, run: expiredSession },
  { name: "a student finds exercises, what is asked, and own attempts only", anywhere: true, run: studentLooksAround },
  { name: "somebody else's attempt is as if it did not exist", anywhere: true, run: foreignAttempt },
  { name: "an admin reads people, stations, devices, jobs and audit", anywhere: true, run: adminReads },
  { name: "more entries than one page are loaded on request", run: pagination },
];

async function wrongPassword(world) {
  const page = await world.open();
  await page.goto("/");
  await signIn(page, { login: world.logins.student.login, password: "not this one" });
  const alert = page.getByRole("alert");
  await alert.waitFor();
  await eventually(async () => assert.match(await alert.innerText(), /Wrong login or password/));
  await eventually(async () => assert.equal(await page.getByLabel("Login").inputValue(), world.logins.student.login));
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
  await page.getByRole("heading", { level: 2, name: "Task" }).waitFor();
  await eventually(async () => assert.match(await page.getByRole("main").innerText(), /Depth\s+[\d.]+\smm/));
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
  await eventually(async () => assert.match(await page.getByRole("alert").innerText(), /Attempt not found/));
  await accessible(page, "a missing attempt");
}

async function adminReads(world) {
  const page = await signedIn(world, "admin");
  for (const [link, title] of [
    ["People", "People"],
    ["Stations", "Stations"],
    ["Devices", "Device profiles"],
    ["Jobs", "Jobs"],
    ["Audit", "Audit"],
  ]) {
    await page.getByRole("link", { name: link, exact: true }).click();
    await page.getByRole("heading", { level: 1, name: title }).waitFor();
    await page.locator("main table").first().waitFor();
    await accessible(page, title);
  }
}

// Texts that a school wrote are not translated.
async function builtInExercisesAreTranslated(page) {
  await page.goto("/exercises");
  await page.getByRole("heading", { name: "Klasse-I-Kavität, okklusal" }).first().waitFor();
  await page.getByText("Einen Kasten", { exact: false }).first().waitFor();
}

async function speaksLanguages(world) {
  const page = await world.open();
  const { login, password } = world.logins.student;
  await page.goto(world.attempt("released"));
  await page.getByRole("button", { name: "Deutsch" }).click();
  await page.getByRole("heading", { name: "Anmelden" }).waitFor();
  await eventually(async () => assert.equal(await page.locator("html").getAttribute("lang"), "de"));
  await accessible(page, "the sign-in in German");
  await world.picture(page, "sign_in_de");
  await page.getByLabel("Anmeldename").fill(login);
  await page.getByLabel("Passwort").fill("not it");
  await page.getByRole("button", { name: "Anmelden", exact: true }).click();
  await page.getByText("Anmeldename oder Passwort ist falsch", { exact: false }).waitFor();
  await page.getByLabel("Passwort").fill(password);
  await page.getByRole("button", { name: "Anmelden", exact: true }).click();
  await page.getByTestId("score").waitFor();
  await eventually(async () => assert.match(await page.locator(".score-card").innerText(), /von 100[\s\S]*Referenz: /));
  await page.getByText("Abweichung in Zahlen").waitFor();
  await builtInExercisesAreTranslated(page);
  // It is kept with the person: another browser, set to English, speaks it after signing in.
  const other = await world.open();
  await other.goto("/account");
  await signIn(other, world.logins.student);
  await other.getByRole("button", { name: "Abmelden" }).waitFor();
  await other.getByLabel("Sprache dieser Seite").selectOption("zh");
  await other.getByRole("button", { name: "退出登录" }).waitFor();
  await eventually(async () => assert.equal(await other.locator("html").getAttribute("lang"), "zh-Hans"));
  await other.goto(world.attempt("released"));
  await other.getByTestId("score").waitFor();
  await world.picture(other, "result_zh", { fullPage: true });
  const teacher = await world.open();
  await teacher.goto(world.grading("graded"));
  await teacher.getByRole("button", { name: "中文" }).click();
  await teacher.getByLabel("用户名").fill(world.logins.instructor.login);
  await teacher.getByLabel("密码").fill(world.logins.instructor.password);
  await teacher.getByRole("button", { name: "登录", exact: true }).click();
  await teacher.getByRole("button", { name: "从第一个开始" }).waitFor();
  await world.picture(teacher, "grading_zh", { fullPage: true });
  await teacher.goto(world.assignment("graded"));
  await teacher.locator(".insight .tenths").first().waitFor();
  await eventually(async () =>
    assert.match(await teacher.locator(".insight").innerText(), /内部形态/, "names of groups"),
  );
  // Why there is no score; the server's own words only where there are no others.
  await teacher.goto(world.attempt("set_aside"));
  await teacher.getByText("这份记录已搁置", { exact: false }).first().waitFor();
}

async function pagination(world) {
  const page = await signedIn(world, "admin", "/audit");
  const table = page.locator("main table");
  await table.waitFor();
  // Of the many rows only those around the window are there.
  const count = async () => Number(await table.getAttribute("aria-rowcount")) - 1;
  for (const more = page.getByRole("button", { name: "Show more" }); ; ) {
    const before = await count();
    await more.click();
    await eventually(async () => assert.ok((await count()) > before, `${before} rows are shown`));
    if ((await more.count()) === 0) break;
  }
  const { audit } = await (await world.as("admin")).get("/audit?limit=1000");
  assert.ok(audit.length - (await count()) <= 2, "what came since the page was opened is not in it");
}
