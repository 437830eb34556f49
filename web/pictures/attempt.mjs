// attempt.mjs PAGE_URL ATTEMPT OUT.png: draws the page of an attempt as its instructor sees it.
import { begin, launch, newPage } from "../../tests/e2e/browser.mjs";
import { toothAtRest } from "../../tests/e2e/pixels.mjs";
import { signIn } from "../../tests/e2e/session.mjs";

const [url, attempt, out] = process.argv.slice(2);
const browser = await launch();
try {
  const page = await newPage(browser, url);
  await begin(page, { width: 1440, height: 900 });
  await page.goto(`/attempts/${attempt}`);
  await signIn(page, { login: "instructor", password: "enamel-demo-instructor" });
  await page.locator(".playback").waitFor({ timeout: 120_000 }); // the server makes it meanwhile
  await page.locator(".tooth-frame[aria-busy=false]").waitFor();
  await page.locator(".plot canvas").waitFor();
  await toothAtRest(page);
  await page.screenshot({ path: out });
} finally {
  await browser.close();
}
