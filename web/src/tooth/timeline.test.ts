import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeChanging } from "./changing";
import {
  expectedSample,
  golden,
  goldenHead,
  goldenPart,
  goldenPlayer,
  isDentin,
  sampleAt,
  segmentOf,
  value,
  wholePlayer,
} from "./golden.test";
import { ToothMesher } from "./mesher";
import { kCoarse } from "./samples";
import { decodeHead, decodeSegment, type Head, type TimelinePlayer } from "./timeline";

test("the golden tooth is at every frame what the document says, whatever the order", async () => {
  const player = await goldenPlayer();
  for (const frames of [0, 1, 2, 3, 4, 5, 2, 5, 0, 4, 3]) {
    value(player.seek(frames));
    for (let brick = 25; brick < 125; ++brick) {
      const samples = player.samples(brick);
      for (let i = 0; i < 512; ++i) {
        const place = sampleAt(brick, i);
        const exact = expectedSample(...place, frames);
        const found = typeof samples === "number" ? samples : samples[i]!;
        const before = frames > 0 && frames < 5;
        if (found !== exact && !(before && found >> kCoarse === exact >> kCoarse))
          assert.fail(`frame ${frames}, brick ${brick}, sample ${i}: expected ${exact}, found ${found}`);
        if (found < 0 && player.tissue(brick, i) !== (isDentin(...place) ? 2 : 1))
          assert.fail(`tissue of brick ${brick}, sample ${i}`);
      }
    }
  }
});

test("head and poses of the golden file are what the document says", async () => {
  const player = await goldenPlayer();
  const { head } = player;
  assert.deepEqual([head.ticks, head.rateHz, head.frameTicks, head.segmentFrames, head.frames], [450, 1000, 100, 2, 5]);
  assert.deepEqual(head.cut, { centreMm: [0, 0, 0.95], radiusMm: 0.552 });
  assert.equal(head.fileBytes, golden("entl").byteLength);
  assert.deepEqual(
    head.outlines.map((outline) => outline.map((point) => point.map((mm) => Math.round(mm * 1e6) / 1e6))),
    [
      [
        [0, 0.1],
        [0.4, 0.2],
        [4, 0],
      ],
    ],
  );
  for (let k = 0; k < 5; ++k) {
    const pose = player.pose(k + 1)!;
    assert.deepEqual(
      pose.tipMm.map((mm) => Math.round(mm * 1000) + 0),
      [0, -5 * k + 0, 1450 - 150 * k],
    );
    assert.deepEqual(
      pose.axis.map((part) => Math.round(part * 127)),
      [0, k, 127],
    );
    assert.equal(pose.turning, k % 2 === 1);
    assert.equal(pose.gapTicks, k);
  }
});

test("seek names the bricks that look otherwise and no others", async () => {
  const player = await goldenPlayer();
  const now = () =>
    Array.from({ length: 125 }, (_, b) => {
      const s = player.samples(b);
      return typeof s === "number" ? String(s) : s.join();
    });
  for (const frames of [0, 2, 3, 5, 1, 4, 4, 0]) {
    const before = now();
    const changed = value(player.seek(frames));
    const after = now();
    for (let b = 0; b < 125; ++b) assert.equal(changed.has(b), before[b] !== after[b], `brick ${b}`);
  }
});

function wholeMesh(player: TimelinePlayer): {
  area: number;
  volume: number;
  edges: Map<string, number>;
  vertices: number;
  worst: number;
  tissues: Set<number>;
} {
  const mesher = new ToothMesher(player);
  const out = {
    area: 0,
    volume: 0,
    edges: new Map<string, number>(),
    vertices: 0,
    worst: 0,
    tissues: new Set<number>(),
  };
  for (const block of mesher.allBlocks()) {
    const mesh = mesher.mesh(block);
    if (mesh === undefined) continue;
    const p = (i: number) =>
      [mesh.positionMm[3 * i]!, mesh.positionMm[3 * i + 1]!, mesh.positionMm[3 * i + 2]!] as const;
    out.vertices += mesh.tissue.length;
    mesh.tissue.forEach((tissue, i) => {
      out.tissues.add(tissue);
      const [x, y, z] = p(i);
      const length = Math.hypot(x, y, z);
      const normal = [0, 1, 2].map((axis) => mesh.normal[4 * i + axis]! / 127);
      out.worst = Math.max(out.worst, Math.abs(length - 1.43));
      assert.ok(
        (normal[0]! * x + normal[1]! * y + normal[2]! * z) / length > 0.98,
        "a ball's normals point away from its middle",
      );
    });
    for (let t = 0; t < mesh.triangle.length; t += 3) {
      const [a, b, c] = [p(mesh.triangle[t]!), p(mesh.triangle[t + 1]!), p(mesh.triangle[t + 2]!)];
      const cross = [
        (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]),
        (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]),
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]),
      ];
      out.area += Math.hypot(...cross) / 2;
      out.volume += (a[0] * cross[0]! + a[1] * cross[1]! + a[2] * cross[2]!) / 6;
      const corners = [a, b, c].map((corner) => corner.map((mm) => mm.toFixed(6)).join());
      for (let e = 0; e < 3; ++e) {
        const [from, to] = [corners[e]!, corners[(e + 1) % 3]!];
        const [key, sign] = from < to ? [`${from} ${to}`, 1] : [`${to} ${from}`, -1];
        out.edges.set(key, (out.edges.get(key) ?? 0) + sign);
      }
    }
  }
  return out;
}

test("the mesh of the ball is closed, lies on it and has its volume and area", async () => {
  const player = await wholePlayer();
  const mesh = wholeMesh(player);
  for (const [edge, sum] of mesh.edges) assert.equal(sum, 0, `edge ${edge} has no partner`);
  assert.ok(mesh.worst < (0.1 / 14.3) * 0.7 + 0.002, `${mesh.worst} mm off`);
  assert.ok(Math.abs(mesh.volume / ((4 / 3) * Math.PI * 1.43 ** 3) - 1) < 0.01, `volume ${mesh.volume}`);
  assert.ok(Math.abs(mesh.area / (4 * Math.PI * 1.43 ** 2) - 1) < 0.01, `area ${mesh.area}`);
  assert.deepEqual([...mesh.tissues], [1]);
});

test("only blocks that were cut are meshed again, and match the mesh of the whole tooth", async () => {
  const player = await wholePlayer();
  const mesher = new ToothMesher(player);
  const blocks = mesher.allBlocks();
  const kept = new Map(blocks.map((block) => [block, mesher.mesh(block)]));
  for (const frames of [1, 4, 2, 5]) {
    const dirty = mesher.blocksOf(value(player.seek(frames)));
    for (const block of dirty) kept.set(block, mesher.mesh(block));
    for (const block of blocks)
      assert.deepEqual(kept.get(block), mesher.mesh(block), `block ${block} after ${frames} frames`);
  }
});

test("damaged and foreign files are refused with what is wrong", async () => {
  const refused = async (file: ArrayBuffer, says: RegExp) => {
    const result = await decodeHead(file);
    assert.equal(result.ok, false);
    assert.match(result.ok ? "" : result.error, says);
  };
  const changed = (at: number, byte: number) => {
    const bytes = new Uint8Array(golden("entl"));
    bytes[at] = byte;
    return bytes.buffer;
  };
  await refused(changed(0, 0), /begins with ENTT/);
  await refused(changed(4, 9), /version 9/);
  await refused(changed(6, 1), /flags/);
  await refused(changed(92, 0), /found/);
  assert.equal(value(await decodeHead(golden("entl").slice(0, 120))), undefined, "the head is not all there");
});

test("an index that claims more than its bytes can hold takes no memory", async () => {
  const head = await goldenHead();
  const bytes = new Uint8Array(segmentOf(head, 0));
  const claim = (change: object): Head => ({ ...head, segments: [{ ...head.segments[0]!, ...change }] });
  for (const bad of [{ changeSize: 4e9 }, { keyBricks: 8e6 }, { changeSize: 5 }])
    assert.equal((await decodeSegment(claim(bad), 0, bytes)).ok, false);
});

test("a brick that is only a neighbour has no triangles of its own, and nothing else is asked of it", async () => {
  const part = value(await decodeChanging(await goldenPart("changing"), (await goldenHead()).grid));
  assert.deepEqual(
    [...part.changing],
    Array.from({ length: 75 }, (_, i) => i + 50),
  );
  const [golden, whole] = [await goldenPlayer(), await wholePlayer()];
  const lowest = (player: TimelinePlayer) => {
    const mesher = new ToothMesher(player);
    let z = Infinity;
    for (const block of mesher.allBlocks())
      mesher.mesh(block)?.positionMm.forEach((mm, i) => {
        if (i % 3 === 2) z = Math.min(z, mm);
      });
    return z;
  };
  // Bricks from z = 16 on; quads of edges that begin there reach one cell below.
  assert.ok(Math.abs(lowest(golden) - (-1.95 + 1.5)) < 0.06, `${lowest(golden)}`);
  assert.ok(lowest(whole) < -1.4);
});

test("damaged parts that change are refused", async () => {
  const bytes = await goldenPart("changing");
  const { grid } = await goldenHead();
  for (let end = 0; end < bytes.length; end += 37)
    assert.equal((await decodeChanging(bytes.slice(0, end), grid)).ok, false, `${end} bytes`);
  for (const at of [0, 3]) {
    const bad = bytes.slice();
    bad[at]! ^= 0x55;
    assert.equal((await decodeChanging(bad, grid)).ok, false);
  }
});
