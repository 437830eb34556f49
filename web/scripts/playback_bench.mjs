// What opening an attempt and moving through it costs in Chromium with software drawing: bytes and
// time until the tooth is there, how long the page's thread is held up, how long a moment takes to
// be shown, and frames a second while the plot is moved.
//   node scripts/playback_bench.mjs [--dist DIR] [--json FILE] [--seeks N] [--slower N]
// Without BASE_URL: the mock server's small attempt. With BASE_URL, LOGIN, PASSWORD and ATTEMPT (an
// id): that server's. --slower: so many times slower a processor. The network is that of a school
// (10 Mbit/s, 40 ms) until the tooth is there. Times depend on the machine and nothing here fails
// by them. Ends with 77 where there is no Chromium.
import { writeFileSync } from "node:fs";
import { loadavg } from "node:os";
import { fileURLToPath } from "node:url";
import { begin, chromiumIsThere, launch, newPage } from "../../tests/e2e/browser.mjs";
import { startMockServer } from "../../tests/e2e/mock_server.mjs";
import { playbackOf } from "../../tests/e2e/mock_tooth.mjs";
import { people } from "../../tests/e2e/mock_world.mjs";

const kSkipped = 77;
const kNetwork = { offline: false, latency: 40, downloadThroughput: 1.25e6, uploadThroughput: 0.5e6 };
const kUnbound = { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: -1 };
const kPanFrames = 120,
  kMostZooms = 20;
const kTickByTick = /tick by tick/;
const kMockAttempt = "00000000-0000-7000-8000-000000000105";

function option(name, otherwise) {
  const at = process.argv.indexOf(name);
  return at < 0 ? otherwise : process.argv[at + 1];
}

// Called in the page before anything of it runs. The browser reports only tasks of 50 ms and more.
function watchTasks() {
  globalThis.longTasks = [];
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) globalThis.longTasks.push(Math.round(entry.duration));
  }).observe({ type: "longtask", buffered: true });
}

// Called in the page: sets the playback's slider, and waits until its tooth is the one of that
// moment and was given to the screen. Milliseconds of each.
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

// Called in the page: drags the plot's part of the time to and fro, a little in each frame. Frames
// per second.
async function pan(frames) {
  const over = document.querySelector(".force-card .u-over");
  const box = over.getBoundingClientRect();
  const frame = () =>
    new Promise((resolve) => {
      requestAnimationFrame(resolve);
    });
  const send = (type, x) =>
    over.dispatchEvent(
      new PointerEvent(type, {
        bubbles: true,
        clientX: box.left + x,
        clientY: box.top + box.height / 2,
        button: 0,
        buttons: 1,
        shiftKey: true,
      }),
    );
  let x = box.width / 2;
  send("pointerdown", x);
  await frame();
  const begun = performance.now();
  for (let i = 0; i < frames; ++i) {
    x += i % 60 < 30 ? -4 : 4;
    send("pointermove", x);
    await frame();
  }
  const seconds = (performance.now() - begun) / 1000;
  send("pointerup", x);
  return frames / seconds;
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
const takeTasks = (page) => page.evaluate(() => globalThis.longTasks.splice(0));

async function measure(browser, { baseUrl, login, password, attempt, seeks, slower }) {
  const page = await newPage(browser, baseUrl);
  const errors = await begin(page);
  await page.addInitScript(watchTasks);
  await page.goto("/");
  await page.getByLabel("Login").fill(login);
  await page.getByLabel("Password").fill(password);
  await page.getByRole("button", { name: "Sign in" }).click();
  await page.locator("main table, main .card").first().waitFor();
  await page.waitForLoadState("networkidle");

  const session = await page.context().newCDPSession(page);
  let bytes = 0;
  session.on("Network.loadingFinished", ({ encodedDataLength }) => {
    bytes += encodedDataLength;
  });
  await session.send("Network.enable");
  await session.send("Network.clearBrowserCache");
  await session.send("Network.emulateNetworkConditions", kNetwork);
  await session.send("Emulation.setCPUThrottlingRate", { rate: slower });
  const begun = performance.now();
  await page.goto(`/attempts/${attempt}`, { waitUntil: "commit" });
  await page.waitForSelector(".tooth-frame[aria-busy=false] canvas", { state: "attached" });
  const found = { first_picture_ms: Math.round(performance.now() - begun), first_picture_bytes: bytes };
  await session.send("Network.emulateNetworkConditions", kUnbound);
  await page.waitForSelector(".playback[data-shown]");
  await page.waitForLoadState("networkidle");
  found.all_bytes = bytes;
  found.longest_block_opening_ms = Math.max(0, ...(await takeTasks(page)));

  const times = await page.evaluate(seekAll, momentsOf(seeks));
  Object.assign(found, {
    seek_median_ms: quantile(times, 0.5),
    seek_p95_ms: quantile(times, 0.95),
    seek_most_ms: quantile(times, 1),
  });
  found.longest_block_seeking_ms = Math.max(0, ...(await takeTasks(page)));

  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForTimeout(3000);
  found.longest_block_playing_ms = Math.max(0, ...(await takeTasks(page)));
  found.frames = Number(await page.locator(".playback input[type=range]").getAttribute("max"));

  // Both ways a plot is drawn: half of the attempt in the series' steps, and three seconds tick by
  // tick.
  await page.keyboard.press("k");
  await page.waitForSelector(".tooth-frame canvas[data-drawn=full]");
  for (let i = 0; i < 2; ++i) await page.keyboard.press("i");
  await takeTasks(page);
  found.pan_steps_per_s = Math.round(await page.evaluate(pan, kPanFrames));
  for (let i = 0; i < kMostZooms && (await page.getByRole("img", { name: kTickByTick }).count()) === 0; ++i) {
    await page.keyboard.press("i");
    await page.waitForLoadState("networkidle");
  }
  await page.getByRole("img", { name: kTickByTick }).locator("canvas").waitFor();
  found.pan_ticks_per_s = Math.round(await page.evaluate(pan, kPanFrames));
  found.longest_block_panning_ms = Math.max(0, ...(await takeTasks(page)));
  if (errors.length > 0) throw new Error(`errors in the browser's console: ${errors.join("; ")}`);
  return found;
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium (install Debian's chromium, or name another with CHROMIUM)");
  process.exit(kSkipped);
}
const real = process.env.BASE_URL;
if (real !== undefined && !(process.env.LOGIN && process.env.PASSWORD && process.env.ATTEMPT))
  throw new Error("BASE_URL is set, so LOGIN, PASSWORD and ATTEMPT are expected; found not all");
const instructor = people.find((person) => person.role === "instructor");
const server =
  real === undefined
    ? await startMockServer({ dist: option("--dist") ?? fileURLToPath(new URL("../dist", import.meta.url)) })
    : undefined;
// The mock server makes its files when they are first asked for, which takes it seconds: no part of
// what is measured.
if (real === undefined) playbackOf();
const browser = await launch();
try {
  const found = await measure(browser, {
    baseUrl: real ?? server.url,
    login: process.env.LOGIN ?? instructor.login,
    password: process.env.PASSWORD ?? instructor.password,
    attempt: process.env.ATTEMPT ?? kMockAttempt,
    seeks: Number(option("--seeks", 100)),
    slower: Number(option("--slower", 1)),
  });
  console.log(
    `against ${real === undefined ? "the mock server" : "a server"}; 10 Mbit/s and 40 ms until the tooth is there; processor ${option("--slower", 1)} times slower`,
  );
  for (const [name, value] of Object.entries(found)) console.log(`${name.padEnd(28)} ${String(value).padStart(10)}`);
  console.log(`load of the machine, last minute ${loadavg()[0].toFixed(1).padStart(10)}`);
  console.log("a block of 0: no task held the page's thread for 50 ms");
  const file = option("--json");
  if (file !== undefined) writeFileSync(file, `${JSON.stringify(found, null, 2)}\n`);
} finally {
  await browser.close();
  await server?.close();
}
