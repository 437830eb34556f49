// What the examiners of examiner.mjs do on the page: one blind mark each, the results, an appeal and its answer, and the printed
// report, in English and Chinese. Nothing where there is no Chromium, or no page.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { chromiumIsThere, launch, newPage } from "../e2e/browser.mjs";
import { readPdf } from "./pdf_text.mjs";

const ok = (text) => console.log(`ok: ${text}`);
// A figure as the page has it.
const shown = (figure) => String(Number(figure.toFixed(1)));
// Where text is broken into lines and pieces, and which letters are one glyph (fl), is the printer's choice.
const dense = (text) => text.normalize("NFKC").replace(/\s+/g, "");

export async function byPage(base, password) {
  const built = (await (await fetch(base)).text()).includes("<script");
  if (!built || !chromiumIsThere()) {
    console.log(`the page is not tried: ${built ? "there is no Chromium" : "it is not built"}`);
    return {};
  }
  const browser = await launch();
  const pages = [];
  const open = async ({ login }, path, locale) => {
    const page = locale === undefined ? await newPage(browser, base) : await (await browser.newContext({ baseURL: base, locale })).newPage();
    pages.push(page);
    page.on("pageerror", (error) => pages.push(assert.fail(`${path}: ${error.message}`)));
    const answer = await page.context().request.post("/api/v1/session", { data: { login, password } });
    assert.equal(answer.status(), 200);
    await page.goto(path);
    return page;
  };

  // `mark` for the first work that is not marked.
  const marks = async (marker, marking, { criteria }, mark) => {
    const page = await open(marker, `/markings/${marking}`);
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    const [{ title: any }] = criteria;
    assert.equal(await page.getByLabel(`Points for ${any}`).count(), 0, "the rating comes first");
    assert.ok(!(await page.locator("main").innerText()).includes("Candidate"), "no name");
    await page.keyboard.press(String(mark.rating));
    for (const { name, title } of criteria) {
      await page.getByLabel(`Points for ${title}`, { exact: true }).fill(String(mark.criteria[name].points));
      await page.getByLabel(`Comment on ${title}`, { exact: true }).fill(mark.criteria[name].comment);
    }
    await page.getByRole("button", { name: "Give this mark" }).click();
    await page.getByRole("button", { name: "Work 1", exact: true, disabled: true }).waitFor();
    await page.context().close();
  };

  const showsResults = async (marker, marking, { standard, works }) => {
    const page = await open(marker, `/markings/${marking}`);
    const { value, low, high } = standard.borderline;
    const text = dense(await page.locator(".pass-mark").innerText());
    for (const figure of [value, low, high]) assert.ok(text.includes(shown(figure)), `${shown(figure)} in ${text}`);
    const rows = await page.getByRole("table", { name: "Marks" }).locator("tbody tr").allInnerTexts();
    assert.equal(rows.length, works.length);
    assert.ok(rows.every((row) => row.includes("Candidate")), "whose work it was");
    await page.context().close();
    ok(`page: the pass mark ${value.toFixed(1)} with ${low.toFixed(1)} to ${high.toFixed(1)}, and ${rows.length} works with names`);
  };

  const appeals = async (student, attempt, text) => {
    const page = await open(student, `/attempts/${attempt}`);
    await page.getByRole("button", { name: "Appeal against the score…" }).click();
    await page.getByLabel("What should be checked again, and why").fill(text);
    await page.getByRole("button", { name: "Send the appeal" }).click();
    await page.getByText("Not answered yet").waitFor();
    await page.context().close();
  };

  const answers = async (instructor, attempt, text) => {
    const page = await open(instructor, `/attempts/${attempt}`);
    await page.getByLabel("Your answer").fill(text);
    await page.getByRole("button", { name: "Answer and rescore" }).click();
    await page.getByText("Rescored").first().waitFor();
    await page.context().close();
  };

  const printed = async (person, attempt, name, locale) => {
    const page = await open(person, `/attempts/${attempt}`, locale);
    await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
    await page.evaluate(() => {
      window.print = () => document.body.setAttribute("data-printed", "");
    });
    await page.getByRole("button", { name: /^(Print|打印)$/ }).click();
    await page.locator("body[data-printed]").waitFor({ state: "attached" });
    const mistakes = await page.locator(".score-card .mistakes > :not(details) li b").allTextContents();
    const errors = await page.locator(".score-card .notice li").allTextContents();
    const bytes = await page.pdf({ format: "A4" });
    if (process.env.ENAMEL_PICTURES) writeFileSync(join(process.env.ENAMEL_PICTURES, `${name}.pdf`), bytes);
    await page.context().close();
    const pdf = readPdf(bytes);
    assert.ok(pdf.pictures >= 5, `${name}: ${pdf.pictures} pictures`);
    return { ...pdf, mistakes, errors, dense: dense(pdf.text) };
  };

  const prints = async (person, { appealed, fingerprint, score, failed, failedScore }) => {
    const report = await printed(person, appealed, "report");
    const says = ({ dense: text }, part) => assert.ok(text.includes(dense(part)), `the report does not say "${part}"`);
    says(report, fingerprint);
    says(report, shown(score.score));
    says(report, shown(Math.min(100, score.score + 2)));
    says(report, "Composite");
    for (const { title } of score.criteria) says(report, title);
    assert.ok(report.mistakes.length > 0, "no mistake");
    for (const mistake of report.mistakes) says(report, mistake);
    const first = await printed(person, failed, "report_failed");
    assert.ok(first.errors.length >= failedScore.critical.length, "every critical error is listed");
    for (const error of ["Not acceptable, whatever else is right", ...first.errors]) says(first, error);
    const [error, mistake] = [first.errors[0], first.mistakes[0]].map((text) => first.dense.indexOf(dense(text)));
    assert.ok(error < mistake, `the critical error is said first: at ${error}, the first mistake at ${mistake}`);
    ok(`printed: ${report.pages} pages with ${report.pictures} pictures, score, ${report.mistakes.length} mistakes and fingerprint`);
    if (execFileSync("fc-list", [":lang=zh-cn"]).length === 0) return console.log("not printed in Chinese: no font has its signs");
    const chinese = await printed(person, appealed, "report_zh", "zh-CN");
    says(chinese, fingerprint);
    const signs = chinese.text.match(/\p{Script=Han}/gu)?.length ?? 0;
    assert.ok(signs > 200, `${signs} Chinese signs`);
    assert.equal(chinese.unknown, 0, "glyphs without a meaning, as boxes are");
    ok(`printed in Chinese: ${signs} signs, fonts ${chinese.fonts.join(", ")}`);
  };

  return { marks, showsResults, appeals, answers, prints, close: () => browser.close() };
}
