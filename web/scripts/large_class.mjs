// What a large class costs who grades it, on a running server with the demo's people:
//   node scripts/large_class.mjs URL ASSIGNMENT COHORT
// Prints for the grading of the assignment and for the cohort's page: seconds until the table is complete, requests,
// their bytes, the page's elements and the seconds in which it did not react (long tasks).
import { launch, newPage } from "../../tests/e2e/browser.mjs";
import { instructor } from "./real_school.mjs";

const [url, assignment, cohort] = process.argv.slice(2);
if (cohort === undefined) throw new Error("expected URL, id of an assignment and id of a cohort");
const browser = await launch();
try {
  for (const [name, path, table] of [
    ["grading", `/grading?assignment=${assignment}`, "table.grading"],
    ["cohort", `/cohorts/${cohort}`, "table.stacking"],
  ]) {
    const page = await newPage(browser, url);
    await page.addInitScript(() => {
      window.longTasksMs = 0;
      new PerformanceObserver((list) => {
        for (const { duration } of list.getEntries()) window.longTasksMs += duration;
      }).observe({ entryTypes: ["longtask"] });
    });
    await page.goto("/");
    await page.getByLabel("Login").fill(instructor.login);
    await page.getByLabel("Password").fill(instructor.password);
    await page.getByRole("button", { name: "Sign in" }).click();
    await page.locator("main table, main .empty").first().waitFor();
    await page.waitForLoadState("networkidle");
    const asked = [];
    page.on("requestfinished", async (request) => {
      if (!new URL(request.url()).pathname.startsWith("/api/")) return;
      asked.push((await request.sizes()).responseBodySize);
    });
    const begun = performance.now();
    await page.goto(path);
    await page.locator(`${table}[aria-rowcount] tr[aria-rowindex]`).first().waitFor();
    const seconds = (performance.now() - begun) / 1000;
    await page.waitForLoadState("networkidle");
    const { rows, nodes, longMs } = await page.evaluate((selector) => {
      const all = document.querySelectorAll("*").length;
      return {
        rows: Number(document.querySelector(selector).getAttribute("aria-rowcount")) - 1,
        nodes: all,
        longMs: window.longTasksMs,
      };
    }, table);
    console.log(
      `${name}: ${rows} rows, ${seconds.toFixed(2)} s, ${asked.length} requests, ` +
        `${(asked.reduce((sum, size) => sum + size, 0) / 1e6).toFixed(2)} MB, ${nodes} nodes, ${(longMs / 1000).toFixed(2)} s of long tasks`,
    );
    await page.context().close();
  }
} finally {
  await browser.close();
}
