import assert from "node:assert/strict";
import { test } from "node:test";
import { DrawingPace, isSoftware, pixelRatio } from "./renderer";

test("renderers without a graphics card are recognised", () => {
  for (const name of [
    "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)",
    "llvmpipe (LLVM 15.0.6, 256 bits)",
    "ANGLE (Microsoft, Microsoft Basic Render Driver Direct3D11)",
    "Apple Software Renderer",
  ])
    assert.equal(isSoftware(name), true, name);
  for (const name of [
    "ANGLE (Intel, Mesa Intel(R) UHD Graphics 620 (KBL GT2), OpenGL 4.6)",
    "NVIDIA GeForce RTX 3060/PCIe/SSE2",
    "Apple M1",
    "WebKit WebGL",
  ])
    assert.equal(isSoftware(name), false, name);
});

test("what moves is drawn quickly where drawing is slow, and in full once it stands; elsewhere always in full", () => {
  let draws = 0;
  let due: (() => void) | undefined;
  const waits: number[] = [];
  const later = (act: () => void, ms: number) => {
    due = act;
    waits.push(ms);
    return () => {
      due = undefined;
    };
  };
  const redraw = () => {
    ++draws;
  };
  let rests = 0;
  const rested = () => {
    ++rests;
  };
  const slow = new DrawingPace(true, redraw, rested, later);
  slow.moved();
  const first = due;
  slow.moved();
  assert.notEqual(due, first, "a later motion puts it off");
  assert.deepEqual([slow.effort, draws], ["quick", 0]);
  due?.();
  assert.deepEqual([slow.effort, draws, rests], ["full", 1, 1]);
  slow.moved(true);
  assert.ok(waits.at(-1)! > waits[0]!, "what is only on the way is not drawn in full");
  slow.stop();
  assert.equal(typeof due, "undefined", "nothing is drawn after the end");
  const fast = new DrawingPace(false, redraw, rested, later);
  fast.moved();
  due?.();
  assert.deepEqual([fast.effort, draws, rests], ["full", 1, 2], "rests, and was drawn in full all the time");
  assert.ok(pixelRatio("quick", 1) < pixelRatio("full", 1));
});
