// What colours a picture on the page has.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { decodePng } from "./png.mjs";

// How many pixels of an element each test holds for.
export async function countColors(page, selector, tests) {
  const picture = decodePng(await page.locator(selector).first().screenshot());
  const counts = Object.fromEntries(Object.keys(tests).map((name) => [name, 0]));
  for (let y = 0; y < picture.height; ++y) {
    for (let x = 0; x < picture.width; ++x) {
      const pixel = picture.at(x, y);
      for (const [name, matches] of Object.entries(tests)) if (matches(pixel)) ++counts[name];
    }
  }
  return counts;
}

export const isTargetLine = ([r, g, b]) => b - g > 60 && b - r > 30;

// Pixels of the tooth for which `test` holds, once it is drawn in full.
export async function toothPixels(page, test) {
  await page.locator(".tooth-frame[aria-busy=false] canvas[data-drawn=full]").first().waitFor();
  return (await countColors(page, ".tooth-frame canvas", { found: test })).found;
}

// Waits until `enough` accepts the count.
export async function toothPixelsBecome(page, what, test, enough) {
  await eventually(async () => {
    const count = await toothPixels(page, test);
    assert.ok(enough(count), `${what}: ${count} pixels`);
  });
}

// The share of pixels that differ clearly.
export function differing(one, other) {
  const [a, b] = [decodePng(one), decodePng(other)];
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  let count = 0;
  for (let y = 0; y < a.height; ++y) {
    for (let x = 0; x < a.width; ++x) if (a.at(x, y).some((value, i) => Math.abs(value - b.at(x, y)[i]) > 12)) ++count;
  }
  return count / (a.width * a.height);
}

// The tooth's picture, twice the same: what moves is drawn quickly and then in full, and the browser may show that a
// little after the page says so.
export async function toothAtRest(page) {
  let before;
  return eventually(async () => {
    const last = before;
    await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
    before = await page.locator(".tooth-frame canvas[data-drawn=full]").screenshot();
    assert.ok(last?.equals(before), "the picture is at rest");
    return before;
  });
}
