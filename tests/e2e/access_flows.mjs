// What people with other eyes, other hands or a poor network meet.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { accessible, signedIn } from "./session.mjs";

export const accessFlows = [
  { name: "a contrast theme keeps every mark that carries a meaning", run: contrastTheme },
  { name: "sliders are silent while an attempt is played, and say the moment when it stops", run: silentSliders },
  { name: "going back returns to the place in a list", run: backToThePlace },
  { name: "a part of the page that could not be loaded comes by itself", run: partComesBack },
  { name: "without WebGL five still views show the tooth, and the tools say why they are off", run: withoutWebGl },
  { name: "a wrong address is told in a sentence", run: wrongAddress },
];

async function contrastTheme(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  for (const there of [".spans .span.contact", ".plot-cursor", ".header nav a[aria-current]"])
    await page.locator(there).first().waitFor({ state: "attached" });
  await page.emulateMedia({ forcedColors: "active" });
  const colours = await page.evaluate(() => {
    const of = (selector, property) => getComputedStyle(document.querySelector(selector))[property];
    return {
      page: of("body", "backgroundColor"),
      marks: [".span.contact", ".plot-cursor"].map((mark) => of(mark, "backgroundColor")),
      open: of(".header nav a[aria-current]", "borderBottomColor"),
      others: of(".header nav a:not([aria-current])", "borderBottomColor"),
    };
  });
  for (const mark of colours.marks) assert.notEqual(mark, colours.page);
  assert.notEqual(colours.open, colours.others);
  await world.picture(page, "contrast_theme");
  await page.emulateMedia({ forcedColors: "none" });
}

async function silentSliders(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  const position = page.getByRole("slider", { name: "Playback position" });
  await position.fill("0");
  for (const slider of [position, page.locator("#timeline")])
    await eventually(async () => assert.match(await slider.getAttribute("aria-valuetext"), /^0:00\.0/));
  await page.evaluate(() => {
    globalThis.said = [];
    const observer = new MutationObserver((changes) => {
      for (const { target } of changes) globalThis.said.push(target.ariaValueText);
    });
    for (const slider of document.querySelectorAll("input[type=range]"))
      observer.observe(slider, { attributeFilter: ["aria-valuetext"] });
  });
  await page.getByRole("button", { name: "Play", exact: true }).click();
  for (const frames of [5, 10, 15])
    await page.waitForFunction((least) => Number(document.querySelector(".playback").dataset.shown) >= least, frames);
  assert.equal(await position.getAttribute("aria-valuetext"), "Playing");
  assert.deepEqual(await page.evaluate(() => globalThis.said), ["Playing", "Playing"], "each slider, once");
  await page.getByRole("button", { name: "Pause", exact: true }).click();
  await eventually(async () => assert.match(await position.getAttribute("aria-valuetext"), /^0:\d\d\.\d of \d:/));
}

async function backToThePlace(world) {
  const page = await signedIn(world, "instructor", "/attempts", { width: 1024, height: 360 });
  const row = page.locator("tbody tr").last();
  await row.waitFor();
  await row.scrollIntoViewIfNeeded();
  const top = await eventually(async () => {
    const now = await page.evaluate(() => window.scrollY);
    assert.ok(now > 100, `${now} px down`);
    return now;
  });
  await row.getByRole("link").first().click();
  await page.locator("main[data-route=attempt]").waitFor();
  await page.goBack();
  await eventually(async () => {
    const now = await page.evaluate(() => window.scrollY);
    assert.ok(Math.abs(now - top) < 40, `back at ${now} px instead of ${top}`);
  });
}

async function partComesBack(world) {
  const page = await signedIn(world, "student", "/attempts");
  await page.locator("tbody tr").first().waitFor();
  await page.route("**/assets/account_page-*", (route) => route.fulfill({ status: 503 }));
  await page.locator(".account-name").click();
  await page.getByText("This part of the page could not be loaded").waitFor();
  await page.unroute("**/assets/account_page-*");
  await page.getByRole("heading", { level: 2 }).first().waitFor();
}

async function withoutWebGl(world) {
  const page = await signedIn(world, "instructor", "/account");
  await page.route("**/assets/worker-*", async (route) => {
    const response = await route.fetch({ maxRetries: 3 });
    const body = `OffscreenCanvas.prototype.getContext = () => null;\n${await response.text()}`;
    const { "content-encoding": _packed, "content-length": _bytes, ...headers } = response.headers();
    await route.fulfill({ headers, body });
  });
  await page.goto(world.attempt("shown"));
  await page.locator(".still-views canvas").nth(4).waitFor();
  assert.deepEqual(await page.locator(".still-views figcaption").allInnerTexts(), [
    "Occlusal",
    "Buccal",
    "Lingual",
    "Mesial",
    "Distal",
  ]);
  const view = page.getByRole("button", { name: "Occlusal", exact: true });
  assert.equal(await view.getAttribute("aria-disabled"), "true");
  assert.match(await view.getAttribute("title"), /needs WebGL 2/);
  assert.equal(await page.getByLabel("Section", { exact: true }).isDisabled(), true);
  await accessible(page, "an attempt without WebGL");
  await world.picture(page, "without_webgl");
}

async function wrongAddress(world) {
  const page = await signedIn(world, "instructor", "/cohorts/not-an-id");
  await page.getByText("Nothing is at this address, or you may not see it. Check the link.").waitFor();
}
