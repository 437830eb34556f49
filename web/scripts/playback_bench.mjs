// What opening an attempt at each of three real teeth and moving through it costs in Chromium with software drawing
// (opening.mjs), and frames a second while the plot is moved. On a real server of its own.
//   node scripts/playback_bench.mjs [--dist DIR] [--json FILE] [--seeks N] [--slower N]
// --slower: so many times slower a processor. Times depend on the machine and nothing here fails by them. Ends with 77
// where there is no Chromium.
import { writeFileSync } from "node:fs";
import { loadavg } from "node:os";
import { fileURLToPath } from "node:url";
import { chromiumIsThere, launch } from "../../tests/e2e/browser.mjs";
import { kSlower, longestTask, openAttempt } from "./opening.mjs";
import { instructor, startSchool } from "./real_school.mjs";

const kSkipped = 77;
const kPanFrames = 120,
  kMaxZooms = 20;
const kTickByTick = /tick by tick/;

function option(name, otherwise) {
  const at = process.argv.indexOf(name);
  return at < 0 ? otherwise : process.argv[at + 1];
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

async function measure(browser, options) {
  const { found, page } = await openAttempt(browser, options);
  await page.getByRole("button", { name: "Play", exact: true }).click();
  await page.waitForTimeout(3000);
  found.block_playing_ms = await longestTask(page);
  // Both ways a plot is drawn: half of the attempt in the series' steps, and three seconds tick by tick.
  await page.keyboard.press("k");
  await page.waitForSelector(".tooth-frame canvas[data-drawn=full]");
  for (let i = 0; i < 2; ++i) await page.keyboard.press("i");
  await longestTask(page);
  found.pan_steps_per_s = Math.round(await page.evaluate(pan, kPanFrames));
  for (let i = 0; i < kMaxZooms && (await page.getByRole("img", { name: kTickByTick }).count()) === 0; ++i) {
    await page.keyboard.press("i");
    await page.waitForLoadState("networkidle");
  }
  await page.getByRole("img", { name: kTickByTick }).locator("canvas").waitFor();
  found.pan_ticks_per_s = Math.round(await page.evaluate(pan, kPanFrames));
  found.block_panning_ms = await longestTask(page);
  await page.context().close();
  return found;
}

if (!chromiumIsThere()) {
  console.log("skipped: no Chromium at /usr/bin/chromium (install Debian's chromium, or name another with CHROMIUM)");
  process.exit(kSkipped);
}
const [seeks, slower] = [Number(option("--seeks", 100)), Number(option("--slower", kSlower))];
const school = await startSchool({
  dist: option("--dist", fileURLToPath(new URL("../dist", import.meta.url))),
  classToGrade: false,
});
const browser = await launch();
const teeth = {};
try {
  for (const { name, attempt } of school.teeth) {
    teeth[name] = await measure(browser, { url: school.url, attempt, seeks, slower, ...instructor });
    console.log(`${name}; 10 Mbit/s and 40 ms until it is there; processor ${slower} times slower`);
    for (const [what, value] of Object.entries(teeth[name]))
      console.log(`${what.padEnd(28)} ${String(value).padStart(10)}`);
  }
  console.log(`load of the machine, last minute ${loadavg()[0].toFixed(1).padStart(10)}`);
  console.log("a block of 0: no task held the page's thread for 50 ms");
  const file = option("--json");
  if (file !== undefined) writeFileSync(file, `${JSON.stringify(teeth, null, 2)}\n`);
} finally {
  await browser.close();
  await school.close();
}
