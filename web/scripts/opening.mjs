// What opening an attempt and moving through it costs in Chromium with software drawing. A browser of its own opens
// it, with nothing in its cache, over the network of a school; then once more with what it kept.
import { performance } from "node:perf_hooks";
import { begin, newPage } from "../../tests/e2e/browser.mjs";

// A small laptop behind a school's wireless network.
export const kSlower = 4;
const kNetwork = { offline: false, latency: 40, downloadThroughput: 1.25e6, uploadThroughput: 0.5e6 };
const kUnbound = { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: -1 };
const kWindow = { width: 1280, height: 720 };

const kWindowMs = 2000; // until the browser has drawn its own window, which is none of the page's work

// Called in the page before anything of it runs. The browser reports only tasks of 50 ms and more. Nothing is looked
// for again and again: on a slowed thread that would be what is measured.
function watch() {
  globalThis.seen = { tasks: [], shift: 0, tooth: {} };
  const { seen } = globalThis;
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) seen.tasks.push(Math.round(duration));
  }).observe({ type: "longtask", buffered: true });
  new PerformanceObserver((list) => {
    for (const { value, hadRecentInput } of list.getEntries()) if (!hadRecentInput) seen.shift += value;
  }).observe({ type: "layout-shift", buffered: true });
  seen.opened = new Promise((resolve) => {
    new MutationObserver((_, observer) => {
      const shown = document.querySelector(".tooth-frame")?.dataset.tooth;
      if (shown !== undefined) seen.tooth[shown] ??= performance.now();
      if (shown !== "fine" || document.querySelector(".playback[data-shown]") === null) return;
      observer.disconnect();
      resolve();
    }).observe(document, { subtree: true, childList: true, attributeFilter: ["data-tooth", "data-shown"] });
  });
}

// Without Playwright, which brings a script into the page that holds its slowed thread for a quarter of a second.
async function ask(session, expression) {
  const { result, exceptionDetails } = await session.send("Runtime.evaluate", {
    expression,
    awaitPromise: true,
    returnByValue: true,
  });
  if (exceptionDetails !== undefined) throw new Error(`${expression}: ${exceptionDetails.text}`);
  return result.value;
}

// Called in the page: sets the playback's slider, and waits until its tooth is the one of that moment and was given
// to the screen. Milliseconds of each.
async function seekAll(moments) {
  const slider = document.querySelector(".playback input[type=range]");
  const frame = () =>
    new Promise((resolve) => {
      requestAnimationFrame(resolve);
    });
  const times = [];
  for (const share of moments) {
    const wanted = String(Math.round(share * Number(slider.max)));
    const begun = performance.now();
    slider.value = wanted;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    while (document.querySelector(".playback").dataset.shown !== wanted) await frame();
    // The frame in which it is drawn has ended when the next one begins.
    await frame();
    await frame();
    times.push(performance.now() - begun);
  }
  return times;
}

// The same moments each time.
function momentsOf(count) {
  let state = 12345;
  return Array.from({ length: count }, () => {
    state = (state * 1103515245 + 12345) % 2 ** 31;
    return state / 2 ** 31;
  });
}

const quantile = (values, share) => {
  const sorted = [...values].sort((a, b) => a - b);
  return Math.round(sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? Number.NaN);
};
export const longestTask = async (page) => Math.max(0, ...(await page.evaluate(() => globalThis.seen.tasks.splice(0))));

// [seconds, bytes] of the scripts of its workers, which are no requests of the page's own.
export const workersOf = (page) =>
  page.evaluate(() =>
    performance
      .getEntriesByType("resource")
      .filter(({ name }) => /\/assets\/worker-/.test(name))
      .map(({ responseEnd, transferSize }) => [responseEnd / 1000, transferSize]),
  );

// Counts what comes over the line; a part that has not come whole counts as far as it came, and a
// worker's script when it is there.
async function countBytes(page, session) {
  const parts = []; // [seconds, bytes]
  const came = new Map();
  let begun;
  session.on("Network.requestWillBeSent", ({ type, timestamp }) => {
    if (type === "Document") begun = timestamp;
  });
  session.on("Network.dataReceived", ({ requestId, timestamp, encodedDataLength }) => {
    came.set(requestId, (came.get(requestId) ?? 0) + encodedDataLength);
    parts.push([timestamp, encodedDataLength]);
  });
  session.on("Network.loadingFinished", ({ requestId, timestamp, encodedDataLength }) =>
    parts.push([timestamp, encodedDataLength - (came.get(requestId) ?? 0)]),
  );
  await session.send("Network.enable");
  // kB until so many ms after the page was asked for.
  return async (ms = Number.POSITIVE_INFINITY) => {
    const all = [...parts.map(([at, bytes]) => [at - begun, bytes]), ...(await workersOf(page))];
    return Math.round(all.reduce((sum, [at, bytes]) => (at <= ms / 1000 ? sum + bytes : sum), 0) / 100) / 10;
  };
}

export async function signedInPage(browser, { url, login, password }) {
  const page = await newPage(browser, url);
  const errors = await begin(page, kWindow);
  const answer = await page.context().request.post("/api/v1/session", { data: { login, password } });
  if (answer.status() !== 200) throw new Error(`${login} cannot sign in: ${answer.status()}`);
  return { page, errors, session: await page.context().newCDPSession(page) };
}

export async function slowDown(session, slower) {
  await session.send("Network.enable");
  await session.send("Network.emulateNetworkConditions", kNetwork);
  await session.send("Emulation.setCPUThrottlingRate", { rate: slower });
}

// Leaves the page open, with the whole attempt there and an unbound network, for who measures more.
export async function openAttempt(browser, { slower = kSlower, seeks = 100, attempt, ...where }) {
  const { page, errors, session } = await signedInPage(browser, where);
  await page.addInitScript(watch);
  const bytes = await countBytes(page, session);
  await page.waitForTimeout(kWindowMs);
  await slowDown(session, slower);
  await page.goto(`/attempts/${attempt}`, { waitUntil: "commit" });
  await ask(session, "seen.opened");
  await page.waitForLoadState("networkidle");
  const { tasks, shift, tooth } = await ask(session, "({ ...seen, tasks: seen.tasks.splice(0), opened: 0 })");
  const { fine, coarse = fine } = tooth;
  const seconds = (ms) => Math.round(ms / 10) / 100;
  const found = {
    bytes_coarse_kb: await bytes(coarse),
    bytes_fine_kb: await bytes(fine),
    bytes_all_kb: await bytes(),
    coarse_s: seconds(coarse),
    fine_s: seconds(fine),
    layout_shift: Math.round(1000 * shift) / 1000,
    tooth_height_px: Math.round((await page.locator(".tooth-frame").boundingBox()).height),
    block_opening_ms: Math.max(0, ...tasks),
  };
  await longestTask(page);
  await session.send("Network.emulateNetworkConditions", kUnbound);
  const times = await page.evaluate(seekAll, momentsOf(seeks));
  Object.assign(found, { scrub_median_ms: quantile(times, 0.5), scrub_p95_ms: quantile(times, 0.95) });
  found.block_scrubbing_ms = await longestTask(page);

  const kept = await countBytes(page, await page.context().newCDPSession(page));
  const begun = performance.now();
  await page.goto(`/attempts/${attempt}`, { waitUntil: "commit" });
  await ask(session, "seen.opened");
  found.warm_s = seconds(performance.now() - begun);
  await page.waitForLoadState("networkidle");
  found.warm_kb = await kept();
  await longestTask(page);
  if (errors.length > 0) throw new Error(`errors in the browser's console: ${errors.join("; ")}`);
  return { found, page };
}
