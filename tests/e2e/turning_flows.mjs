// How a tooth is turned, moved and come near to, by mouse and by fingers.
import assert from "node:assert/strict";
import { eventually } from "./browser.mjs";
import { toothAtRest } from "./pixels.mjs";
import { signedIn } from "./session.mjs";

export const turningFlows = [
  { name: "fingers turn, move and near the tooth, and scroll the page beside it", run: byFingers },
  { name: "the mouse turns and moves the tooth, looks at a place, and goes back", run: byMouse },
];

const kNear = 0.02; // of angles, rad, and of lengths, mm

// From where the tooth is looked at, as a link has it.
async function lookOf(page) {
  await toothAtRest(page);
  await page.getByRole("button", { name: "Link to this moment" }).evaluate(async (button) => {
    button.click();
    await new Promise((shown) => requestAnimationFrame(() => requestAnimationFrame(shown)));
  });
  const link = await page.locator(".moment-link code").innerText();
  const [around, polar, fits, ...centre] = /view=([-\d._]+)/.exec(link)[1].split("_").map(Number);
  return { around, polar, fits, centre };
}

const apart = (one, other) => Math.hypot(...one.centre.map((value, axis) => value - other.centre[axis]));
const turned = (one, other) => Math.hypot(one.around - other.around, one.polar - other.polar);

async function opened(world) {
  const page = await signedIn(world, "instructor", world.attempt("shown"));
  await page.locator(".tooth-frame[aria-busy=false] canvas").waitFor();
  await page.locator(".plot canvas").waitFor();
  await page.evaluate(() => scrollTo(0, 0));
  const { x, y, width, height } = await page.locator(".tooth-frame").boundingBox();
  return { page, at: (right, down) => ({ x: x + width * right, y: y + height * down }), begun: await lookOf(page) };
}

const scrolled = (page) => page.evaluate(() => scrollY);

async function byFingers(world) {
  const { page, at, begun } = await opened(world);
  const session = await page.context().newCDPSession(page);
  await session.send("Emulation.setTouchEmulationEnabled", { enabled: true, maxTouchPoints: 2 });
  const touch = (type, ...places) =>
    session.send("Input.dispatchTouchEvent", { type, touchPoints: places.map((place, id) => ({ ...place, id })) });
  // From one set of places to another.
  const drag = async (from, to) => {
    await touch("touchStart", ...from);
    for (const share of [0.25, 0.5, 0.75, 1])
      await touch(
        "touchMove",
        ...from.map(({ x, y }, i) => ({ x: x + (to[i].x - x) * share, y: y + (to[i].y - y) * share })),
      );
    await touch("touchEnd");
    return lookOf(page);
  };

  const down = await drag([at(0.5, 0.4)], [at(0.5, 0.6)]);
  assert.ok(Math.abs(down.polar - begun.polar) > 0.3, `down turns up and down: ${begun.polar}, ${down.polar}`);
  assert.ok(Math.abs(down.around - begun.around) < kNear && apart(down, begun) < kNear);
  const right = await drag([at(0.4, 0.5)], [at(0.6, 0.5)]);
  assert.ok(Math.abs(right.around - down.around) > 0.3, `right turns around: ${down.around}, ${right.around}`);
  assert.ok(Math.abs(right.polar - down.polar) < kNear && apart(right, down) < kNear);

  const near = await drag([at(0.45, 0.5), at(0.55, 0.5)], [at(0.35, 0.5), at(0.65, 0.5)]);
  assert.ok(near.fits < 0.5 * right.fits, `fingers that go apart come near: ${right.fits}, ${near.fits}`);
  assert.ok(turned(near, right) < kNear);
  const moved = await drag([at(0.45, 0.5), at(0.55, 0.5)], [at(0.45, 0.7), at(0.55, 0.7)]);
  assert.ok(apart(moved, near) > 0.1, `two fingers move: ${near.centre}, ${moved.centre}`);
  assert.ok(turned(moved, near) < kNear && Math.abs(moved.fits / near.fits - 1) < 0.1);
  assert.equal(await scrolled(page), 0, "nothing on the tooth scrolls the page");

  const { x, y, width } = await page.locator(".score-card").boundingBox();
  // Again where a loaded machine lets the finger rest so long that Chromium takes it for a long press.
  await eventually(async () => {
    await drag([{ x: x + width / 2, y: y + 200 }], [{ x: x + width / 2, y: y + 20 }]);
    assert.ok((await scrolled(page)) > 50, "beside the tooth a finger scrolls the page");
  });
  await session.send("Emulation.setTouchEmulationEnabled", { enabled: false });
}

async function byMouse(world) {
  const { page, at, begun } = await opened(world);
  const { mouse } = page;
  const drag = async (button, from, to) => {
    await mouse.move(from.x, from.y);
    await mouse.down({ button });
    await mouse.move(to.x, to.y, { steps: 4 });
    await mouse.up({ button });
    return lookOf(page);
  };
  const axes = () =>
    page.locator(".tooth-axes line").evaluateAll((lines) => lines.map((line) => line.getAttribute("x2")).join(" "));

  const before = await axes();
  const right = await drag("left", at(0.4, 0.5), at(0.6, 0.6));
  assert.ok(turned(right, begun) > 0.3 && apart(right, begun) < kNear, "the left button turns");
  assert.notEqual(await axes(), before, "the axes turn too");
  const moved = await drag("right", at(0.4, 0.5), at(0.5, 0.5));
  assert.ok(apart(moved, right) > 0.1 && turned(moved, right) < kNear, "the right button moves");
  const { x, y } = at(0.4, 0.4);
  await mouse.dblclick(x, y);
  const looked = await eventually(async () => {
    const look = await lookOf(page);
    assert.ok(apart(look, moved) > 0.1, "a double click looks at a place");
    return look;
  });
  assert.ok(turned(looked, moved) < kNear && Math.abs(looked.fits / moved.fits - 1) < kNear);
  await page.getByRole("button", { name: "Reset", exact: true }).click();
  const reset = await lookOf(page);
  assert.ok(turned(reset, begun) < kNear && apart(reset, begun) < kNear, "as it began");
  assert.ok(Math.abs(reset.fits / begun.fits - 1) < kNear);
}
