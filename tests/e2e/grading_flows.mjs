// How instructors grade a class, and narrow a list of attempts.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { accessible, signedIn, signIn } from "./session.mjs";

export const gradingFlows = [
  { name: "an assignment's attempts are graded one after the other", run: grading },
  { name: "several attempts are released together, and that is undone", run: bulkRelease },
  { name: "an excuse and a new score of several attempts are taken back", run: bulkUndo },
  { name: "an assignment is graded by keyboard", run: gradingByKeys },
  { name: "a release by one key is taken back by another, on the next attempt and on the list", run: releaseTakenBack },
  { name: "a motion near another's shows which, with its figures", run: nearAnother },
  {
    name: "an exam's attempt shows a reviewer who signed and how the hand moved, and the student nothing",
    run: handInExam,
  },
  { name: "attempts are narrowed by exercise, state, flag and appeal", run: narrow },
];

// Scored attempts of the class, as the server has them.
async function gradedOf(world) {
  const teacher = await world.as("instructor");
  const all = [];
  for (let cursor = ""; cursor !== undefined; ) {
    const { attempts, next } = await teacher.get(`/attempts?assignment=${world.school.assignments.graded}${cursor}`);
    all.push(...attempts);
    cursor = next ? `&before=${next}` : undefined;
  }
  return all;
}
async function countOf(world, is) {
  return (await gradedOf(world)).filter(is).length;
}
const isReleased = ({ released }) => released;

const namesIn = (page) => page.locator("table.grading tbody th").allInnerTexts();

async function grading(world) {
  const page = await signedIn(world, "instructor", "/grading");
  await page.getByText("Choose what to grade").waitFor();
  await page.locator("main").getByRole("link", { name: "assignments" }).click();
  await page.locator(`main a[href="${world.grading("graded")}"]`).click();
  await page.locator("table.grading .lost-much").first().waitFor();
  await accessible(page, "grading");
  await world.picture(page, "grading", { fullPage: true });
  const flags = page.locator("table.grading .flags");
  await flags.getByText(/Stopped early: 0\.\d % done/).waitFor(); // in words, without a pointer over it
  // Many rows are seen, and names stay in view.
  const rows = await page.locator("table.grading tbody tr").evaluateAll((all) => all.map((row) => row.clientHeight));
  assert.ok(rows.reduce((sum, height) => sum + height, 0) < 48 * rows.length, rows.join());
  await page.locator(".table-frame").evaluate((frame) => {
    frame.scrollLeft = frame.scrollWidth;
  });
  const [frame, name] = [page.locator(".table-frame"), page.locator("table.grading tbody th").first()];
  const [outer, inner] = [await frame.boundingBox(), await name.boundingBox()];
  assert.ok(inner.x >= outer.x && inner.x < outer.x + 100, `the name is at ${inner.x}, the table at ${outer.x}`);
  await page.getByRole("button", { name: "Score", exact: true }).click();
  await page.locator("th[aria-sort=ascending]", { hasText: "Score" }).waitFor();
  await page.getByLabel("Student", { exact: true }).fill("student");
  const names = await namesIn(page);
  assert.ok(names.length > 4 && names.every((name) => name.startsWith("Student ")), names.join());
  const waits = page.locator("table.grading tr", { hasText: "To release" }).first().locator("th a");
  const at = names.indexOf(await waits.innerText());
  await waits.click();
  await page.getByText(`${at + 1} of ${names.length}`, { exact: true }).waitFor();
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.getByLabel(/New remark/).fill("Keep the wall upright.");
  await page.getByRole("button", { name: "Save this text" }).click();
  await page.getByRole("button", { name: "Add remark" }).click();
  await page.locator(".annotation", { hasText: "Keep the wall upright." }).waitFor();
  await accessible(page, "an attempt of the list");
  const here = page.url().split("/").at(-1);
  await page.getByRole("button", { name: "Release, then next" }).click();
  await page.getByText(`${at + 2} of ${names.length}`, { exact: true }).waitFor();
  assert.equal((await (await world.as("instructor")).get(`/attempts/${here}`)).released, true);
  await page.getByText("Saved texts (1)").click();
  await page.getByRole("button", { name: "Keep the wall upright.", exact: true }).click();
  await eventually(async () =>
    assert.equal(await page.getByLabel(/New remark/).inputValue(), "Keep the wall upright."),
  );
  await page.getByRole("link", { name: "Previous", exact: true }).click();
  await page.getByText(`${at + 1} of ${names.length}`, { exact: true }).waitFor();
  await page.getByRole("link", { name: "Back to the list" }).click();
  await page.locator("th[aria-sort=ascending]", { hasText: "Score" }).waitFor();
  await eventually(async () => assert.equal(await page.getByLabel("Student", { exact: true }).inputValue(), "student"));
  await page.waitForFunction(() => document.activeElement?.matches("table.grading tbody th a"));
  assert.deepEqual(await namesIn(page), names, "the list is as it was");
}

async function bulkRelease(world) {
  const page = await signedIn(world, "instructor", world.grading("graded"));
  await page.locator("table.grading .lost-much").first().waitFor();
  const before = await countOf(world, isReleased);
  await page.getByLabel("Select all shown").check();
  const button = page.getByRole("button", { name: /^Release \d+$/ });
  const count = Number((await button.innerText()).split(" ")[1]);
  assert.ok(count > 5);
  await button.click();
  await page.getByText(`${count} scores released.`).waitFor();
  assert.equal(await countOf(world, isReleased), before + count);
  await accessible(page, "after releasing several");
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByText(`${count} releases withdrawn.`).waitFor();
  assert.equal(await countOf(world, isReleased), before);
}

async function bulkUndo(world) {
  await world.opened.restart("--job-threads", "0"); // what is asked for waits
  const page = await signedIn(world, "instructor", world.grading("graded"));
  await page.locator("table.grading .lost-much").first().waitFor();
  await page.getByLabel("Select all shown").check();
  const excused = () => countOf(world, ({ flags }) => flags.includes("excused"));
  const before = await excused();
  await page.getByRole("button", { name: "Excuse…" }).click();
  await page.getByLabel("Why these attempts do not count").fill("The power failed.");
  await page.getByRole("button", { name: "Excuse", exact: true }).click();
  const told = await page.getByText(/^\d+ attempts excused\.$/).innerText();
  const count = Number(told.split(" ")[0]);
  assert.equal(await excused(), before + count);
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByText(`${count} attempts count again.`).waitFor();
  assert.equal(await excused(), before);
  const scored = async () =>
    (await gradedOf(world)).filter(({ state }) => state === "scored").map(({ id, score }) => `${id} ${score}`);
  const settled = await scored();
  await page.getByLabel("Select all shown").check();
  await page.getByRole("button", { name: "Rescore…" }).click();
  await page.getByRole("button", { name: "Rescore", exact: true }).click();
  await page.getByText(/^\d+ attempts are waiting to be rescored\.$/).waitFor();
  const admin = await world.as("admin");
  const waiting = async () => (await admin.get("/jobs?state=queued&limit=100")).jobs.length;
  assert.equal(await waiting(), settled.length);
  await accessible(page, "after asking for scores");
  await page.getByRole("button", { name: "Undo" }).click();
  await page.getByText(/^The earlier scores of \d+ attempts count again\.$/).waitFor();
  assert.equal(await waiting(), 0);
  assert.deepEqual(await scored(), settled);
}

async function gradingByKeys(world) {
  const page = await signedIn(world, "instructor", world.grading("graded"));
  await page.locator("table.grading .lost-much").first().waitFor();
  await page.keyboard.press("?");
  await page.getByRole("dialog").getByText("Search by name").waitFor();
  await accessible(page, "the list of keys");
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "detached" }); // while it is open, keys are its own
  for (const key of ["j", "j", "x"]) await page.keyboard.press(key);
  await page.getByText("1 attempt selected:").waitFor();
  await page.keyboard.press("o");
  await page.getByText(/^2 of \d+$/).waitFor();
  await page.getByRole("heading", { name: "Remarks" }).waitFor();
  await page.keyboard.press("n");
  await page.getByText(/^3 of \d+$/).waitFor();
  await page.getByRole("heading", { name: "Remarks" }).waitFor();
  await page.keyboard.press("c");
  await page.keyboard.type("n p r b?");
  const typed = (where, text = "n p r b?") =>
    eventually(async () => assert.equal(await page.getByLabel(/New remark/).inputValue(), text, where));
  await typed("what is typed is text");
  // What is not sent yet is there again: after the next attempt, a reload, and the end of the session.
  await page.keyboard.press("Escape");
  await page.keyboard.press("n");
  await page.getByText(/^4 of \d+$/).waitFor();
  await typed("another attempt has remarks of its own", "");
  await page.keyboard.press("p");
  await page.getByText(/^3 of \d+$/).waitFor();
  await typed("after the next attempt");
  await page.reload();
  await typed("after a reload");
  await page.getByLabel(/New remark/).focus();
  await page.context().clearCookies();
  // A request of the page's own may end the session before the key does; the field is gone then.
  await page.keyboard.press("Control+Enter");
  await page.getByText("Your session has ended").waitFor();
  await signIn(page, world.logins.instructor);
  await typed("after signing in again");
  await page.getByLabel(/New remark/).press("Control+Enter");
  await page.locator(".annotation", { hasText: "n p r b?" }).waitFor();
  await page.getByLabel(/New remark/).fill("Not sent.");
  await page.getByRole("button", { name: "Sign out" }).click();
  await page.getByRole("button", { name: "Sign in" }).waitFor();
  assert.deepEqual(await page.evaluate(() => Object.keys(localStorage).filter((key) => /draft/.test(key))), []);
  await signIn(page, world.logins.instructor);
  await page.getByRole("button", { name: "Sign out" }).waitFor();
  await page.goto(world.grading("graded"));
  await page.locator("table.grading .lost-much").first().waitFor();
  await page.keyboard.press("o");
  await page.getByRole("heading", { name: "Remarks" }).waitFor();
  await page.keyboard.press("b");
  await page.locator("table.grading").waitFor();
}

async function releaseTakenBack(world) {
  const page = await signedIn(world, "instructor", world.grading("graded"));
  await page.locator("table.grading .lost-much").first().waitFor();
  const row = () => page.locator("table.grading tbody tr", { hasText: "To release" });
  const teacher = await world.as("instructor");
  const released = async (own) => (await teacher.get(`/attempts/${own}`)).released;
  // With another one after it.
  const own = await row().first().getAttribute("data-id");
  await row().first().locator("th a").click();
  await page.getByRole("button", { name: "Release, then next" }).waitFor();
  const place = page.locator(".queue").getByText(/^\d+ of \d+$/);
  const of = Number.parseInt(await place.innerText(), 10);
  await page.keyboard.press("r");
  await page.getByText(new RegExp(`^${of + 1} of \\d+$`)).waitFor();
  await page.getByText("can now see the score.").waitFor();
  assert.equal(await released(own), true);
  await page.getByRole("heading", { name: "Remarks" }).waitFor();
  await accessible(page, "an attempt after a release");
  await world.picture(page, "released_undo");
  await page.keyboard.press("?");
  await page.getByRole("dialog").getByText("Withdraw release", { exact: true }).waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "detached" });
  await page.keyboard.press("w");
  await page.getByText("can no longer see the score.").waitFor();
  assert.equal(await released(own), false);
  await page.getByText(new RegExp(`^${of + 1} of \\d+$`)).waitFor();
  // The last one of the list: back there.
  const last = world.school.attempts.class11;
  await page.keyboard.press("b");
  await page.locator("table.grading .lost-much").first().waitFor();
  await page.getByLabel("Student", { exact: true }).fill("Hohenberg");
  await row().first().locator("th a").click();
  await page.getByText("1 of 1", { exact: true }).waitFor();
  await page.getByRole("button", { name: "Release, then next" }).waitFor();
  await page.keyboard.press("r");
  await page.locator("table.grading").waitFor();
  await page.getByText("can now see the score.").waitFor();
  assert.equal(await released(last), true);
  await accessible(page, "the list after a release");
  await page.getByRole("button", { name: "Withdraw release" }).click();
  await page.getByText("can no longer see the score.").waitFor();
  assert.equal(await released(last), false);
}

async function nearAnother(world) {
  const page = await signedIn(world, "instructor", world.attempt("class12"));
  const card = page.locator(".card", { hasText: "This proves nothing and costs no points" });
  await card.waitFor();
  await eventually(async () =>
    assert.match(
      await card.innerText(),
      /within 0\.\d\d\s?mm of its path in an earlier attempt by .+ motions .+ is \d+\.\d\d\s?mm/,
    ),
  );
  await accessible(page, "a motion near another's");
  await card.scrollIntoViewIfNeeded();
  await world.picture(page, "near_another");
  await card.getByRole("link").click();
  await page.waitForURL((url) => url.pathname !== world.attempt("class12"));
}

async function handInExam(world) {
  const page = await signedIn(world, "instructor", world.attempt("exam"));
  const card = page.locator(".card", { hasText: "How the hand moved" });
  await card.waitFor();
  const text = await card.innerText();
  assert.match(text, /Not sorted: the assignment has fewer than 5 attempts to compare/);
  assert.match(text, /Tremor, 8 to 12 Hz/);
  assert.match(text, /Nobody can know from this who held the tool/);
  const signed = await page.locator(".card", { hasText: "Signed at the chair" }).innerText();
  assert.match(signed, /At the start\s+Instructor One, .+\s+At the end\s+Instructor One, /);
  await page.getByRole("button", { name: "Release score" }).click();
  await page.getByText("Score released").waitFor();
  const student = await signedIn(world, "student", world.attempt("exam"));
  await student.getByRole("heading", { name: "All measurements" }).waitFor();
  assert.equal(await student.getByText("How the hand moved").count(), 0);
  assert.equal(await student.getByText("Signed at the chair").count(), 0);
}

async function narrow(world) {
  const page = await signedIn(world, "instructor", "/assignments");
  await page.locator("main article, main tbody tr").first().waitFor();
  // While the server is away the list says so; it comes by itself once the server is back.
  const away = (route) => route.fulfill({ status: 503, contentType: "application/json", body: "{}" });
  await page.route(/\/api\/v1\/attempts\?/, away);
  await page.getByRole("link", { name: "Attempts", exact: true }).click();
  const rows = page.locator("tbody tr");
  await page.getByRole("alert").waitFor();
  await page.unroute(/\/api\/v1\/attempts\?/, away);
  await page.evaluate(() => window.dispatchEvent(new Event("online")));
  await rows.first().waitFor();
  await page.getByLabel("State").selectOption({ label: "Set aside" });
  await page.waitForURL(/state=quarantined/);
  await page.waitForFunction(() => document.querySelectorAll("tbody tr").length === 1);
  await page.getByLabel("State").selectOption({ label: "Any" });
  await page.getByLabel("Only with").selectOption({ label: "Similar motion" });
  await page.waitForFunction(() => document.querySelectorAll("tbody tr").length === 1);
  await rows.getByRole("link", { name: "Student Twelve" }).waitFor();
  await page.getByLabel("Only with").selectOption({ label: "–" });
  await page.getByLabel("Student", { exact: true }).fill("student one");
  await page.waitForURL(/name=student\+one/);
  await page.getByLabel("Order").selectOption({ label: "Lowest score first" });
  await page.waitForFunction(() => {
    const all = [...document.querySelectorAll("tbody tr")];
    const scores = all
      .map((row) => Number.parseFloat(row.querySelector(".score-cell").textContent))
      .filter(Number.isFinite);
    return (
      scores.length > 3 &&
      all.every((row) => row.textContent.startsWith("Student One")) &&
      scores.every((score, i) => i === 0 || score >= scores[i - 1])
    );
  });
  await accessible(page, "attempts by name and score");
  await page.getByLabel("Student", { exact: true }).fill("");
  await page.getByLabel("Cohort").selectOption({ label: "Preclinic, second term" });
  await page.getByText("5 students").waitFor();
}
