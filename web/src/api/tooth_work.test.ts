import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeHead, decodeStartTooth, segmentBytes, TimelinePlayer, decodeSegment } from "./timeline";
import { decodeDeviation, kNotCompared } from "./tooth_deviation";
import { ToothLink } from "./tooth_link";
import { type BlockMesh, ToothMesher } from "./tooth_mesh";
import { type ToothTold, ToothWork } from "./tooth_work";

const golden = (name: string) => new Uint8Array(readFileSync(`../schemas/golden/surface_timeline.${name}`)).buffer;

function value<T>(result: { ok: true; value: T } | { ok: false; error: string }): T {
  assert.ok(result.ok, result.ok ? "" : result.error);
  return result.value;
}

// A link and its work in one thread: what is asked arrives later, as between a page and its worker.
// `pause` is called between two slices; `sliceMs` of 0 is a slice for each block.
function linked({ sliceMs = 1e9, pause = async () => {} }: { sliceMs?: number; pause?: () => Promise<void> } = {}) {
  const blocks = new Map<number, BlockMesh>();
  const told: ToothTold[] = [];
  const shown: number[] = [];
  const failures: string[] = [];
  let now = 0;
  const port: ConstructorParameters<typeof ToothLink>[0] = {
    postMessage: (asked) => {
      queueMicrotask(() => void work.take(asked));
    },
    onmessage: null,
    onerror: null,
    terminate: () => {},
  };
  const work = new ToothWork(
    (message) => {
      told.push(message);
      port.onmessage?.({ data: message });
    },
    pause,
    () => {
      now += 13 - Math.min(sliceMs, 13);
      return now;
    },
  );
  const link = new ToothLink(port, {
    blocks: (all) => {
      for (const [index, mesh] of all) {
        if (mesh === undefined) blocks.delete(index);
        else blocks.set(index, mesh);
      }
    },
    shown: (frames) => {
      shown.push(frames);
    },
    failed: (message) => {
      failures.push(message);
    },
  });
  return { link, port, blocks, told, shown, failures };
}

const settled = () =>
  new Promise<void>((resolve) => {
    setTimeout(resolve, 5);
  });

async function opened(made: ReturnType<typeof linked>, segments = [0, 1, 2]) {
  const file = golden("entl");
  const head = value(await made.link.head(file.slice(0)));
  value(await made.link.start(golden("entb")));
  for (const i of segments)
    value(
      await made.link.segment(
        i,
        file.slice(head.segments[i]!.from, head.segments[i]!.from + segmentBytes(head.segments[i]!)),
      ),
    );
  return head;
}

// The blocks at a moment, made without any worker.
async function expected(frames: number, deviation?: ArrayBuffer): Promise<Map<number, BlockMesh>> {
  const file = golden("entl");
  const head = value(await decodeHead(file))!;
  const player = new TimelinePlayer(head, value(await decodeStartTooth(golden("entb"))));
  for (const [i, segment] of head.segments.entries())
    player.add(
      i,
      value(
        await decodeSegment(head, i, new Uint8Array(file.slice(segment.from, segment.from + segmentBytes(segment)))),
      ),
    );
  value(player.seek(frames));
  const mesher = new ToothMesher(player);
  if (deviation !== undefined) mesher.deviation = value(await decodeDeviation(deviation));
  return new Map(
    mesher.allBlocks().flatMap((block) => {
      const mesh = mesher.mesh(block);
      return mesh === undefined ? [] : [[block, mesh] as const];
    }),
  );
}

test("a wish gives the blocks of that moment, and only then says that it is shown", async () => {
  const made = linked();
  await opened(made);
  for (const frames of [5, 2, 0, 4]) {
    made.link.seek(frames);
    await settled();
    assert.deepEqual(made.blocks, await expected(frames), `after ${frames} frames`);
    assert.equal(made.told.at(-1)?.told, "shown");
  }
  assert.deepEqual(made.shown, [5, 2, 0, 4]);
});

test("a coarse tooth is shown at once and until all of the fine one is there", async () => {
  const made = linked({ sliceMs: 0 });
  value(await made.link.coarse(golden("entb")));
  assert.equal(made.blocks.size, 1);
  const [number] = [...made.blocks.keys()];
  await opened(made);
  assert.deepEqual([...made.blocks.keys()], [number], "nothing of the fine one before a moment is wished for");
  made.told.length = 0;
  made.link.seek(5);
  await settled();
  const first = made.told.find(({ told }) => told === "blocks");
  assert.ok(first?.told === "blocks" && first.blocks.length > 1 && first.blocks[0]?.[1] === undefined);
  assert.deepEqual(made.blocks, await expected(5));
  // One that comes late changes nothing.
  value(await made.link.coarse(golden("entb")));
  assert.deepEqual(made.blocks, await expected(5));
});

test("the position of the tooth is reported with the start tooth", async () => {
  const made = linked();
  value(await made.link.head(golden("entl")));
  const { centreMm, radiusMm } = value(await made.link.start(golden("entb")));
  for (const mm of centreMm) assert.ok(Math.abs(mm) < 0.06, `${centreMm}`);
  assert.ok(Math.abs(radiusMm - 1.43) < 0.1, `${radiusMm}`);
});

test("a wish that is overtaken is left where it is, and the later one is whole", async () => {
  let pauses = 0;
  const made = linked({
    sliceMs: 0,
    pause: async () => {
      if (++pauses === 2) made.link.seek(3);
      await settled();
    },
  });
  await opened(made);
  made.link.seek(5);
  for (let i = 0; i < 40; ++i) await settled();
  assert.deepEqual(made.shown, [3], "the first was never shown");
  const last = made.told.at(-1);
  assert.ok(
    last?.told === "shown" &&
      last.cut !== undefined &&
      Math.abs(last.cut.centreMm[0]) < 0.1 &&
      last.cut.centreMm[2] > 0.8,
    "where it was cut is known anyway",
  );
  assert.deepEqual(made.blocks, await expected(3));
});

test("every block is meshed in the end, however often requests overtake each other", async () => {
  let pauses = 0;
  const made = linked({
    sliceMs: 0,
    pause: async () => {
      if (++pauses < 60) made.link.seek(pauses % 6);
      await settled();
    },
  });
  await opened(made);
  made.link.seek(5);
  for (let i = 0; i < 200 && made.shown.length === 0; ++i) await settled();
  assert.equal(made.shown.length, 1);
  assert.deepEqual(made.blocks, await expected(made.shown[0]!));
});

test("a wish for a part that is not here yet is fulfilled when it is", async () => {
  const made = linked();
  await opened(made, [2]);
  made.link.seek(1);
  await settled();
  assert.deepEqual(made.shown, []);
  const head = value(await decodeHead(golden("entl")))!;
  value(
    await made.link.segment(
      0,
      golden("entl").slice(head.segments[0]!.from, head.segments[0]!.from + segmentBytes(head.segments[0]!)),
    ),
  );
  await settled();
  assert.deepEqual(made.shown, [1]);
  assert.deepEqual(made.blocks, await expected(1));
});

test("the golden deviation is what the document says, and is at the vertices of its cells", async () => {
  const { bricks, values } = value(await decodeDeviation(golden("endv")));
  const made = linked();
  await opened(made);
  made.link.seek(2);
  await settled();
  const compared = value(await made.link.deviation(golden("endv")));
  await settled();
  assert.equal(values, 369);
  assert.equal(compared.deviationMm.length, values, "each cell's vertex once, although neighbouring blocks share some");
  let seen = 0;
  for (const [brick, own] of bricks) {
    own.forEach((um, i) => {
      if (um === kNotCompared) return;
      ++seen;
      const [x, y, z] = [
        (brick % 5) * 8 + (i & 7),
        (Math.floor(brick / 5) % 5) * 8 + ((i >> 3) & 7),
        Math.floor(brick / 25) * 8 + (i >> 6),
      ];
      assert.equal(um, 100 * (z - 24) + 10 * (x - 19) - (y - 19));
    });
  }
  assert.equal(seen, values);
  compared.deviationMm.forEach((mm, i) => {
    const [x, y, z] = [0, 1, 2].map((axis) => Math.floor((compared.positionMm[3 * i + axis]! + 1.95) / 0.1)) as [
      number,
      number,
      number,
    ];
    assert.ok(Math.abs(mm - (100 * (z - 24) + 10 * (x - 19) - (y - 19)) / 1000) < 1e-6);
  });
  assert.deepEqual(made.blocks, await expected(2, golden("endv")), "what was shown is still shown, with the deviation");
  made.link.seek(5);
  await settled();
  assert.deepEqual(made.blocks, await expected(5, golden("endv")));
});

test("damaged files and a worker that stops are reported, and nothing is thrown", async () => {
  const made = linked();
  assert.match(JSON.stringify(await made.link.head(golden("entb"))), /begins with ENTT/);
  assert.match(JSON.stringify(await made.link.start(golden("entb"))), /came before the head/);
  value(await made.link.head(golden("entl")));
  assert.match(JSON.stringify(await made.link.start(golden("endv"))), /begins with ENTS/);
  assert.match(JSON.stringify(await made.link.deviation(golden("endv").slice(0, 200))), /ends early/);
  for (let end = 0; end < golden("endv").byteLength; ++end)
    assert.equal((await decodeDeviation(golden("endv").slice(0, end))).ok, false, `${end} bytes`);
  const lost = made.link.segment(0, new ArrayBuffer(3));
  made.port.onerror?.({});
  assert.match(JSON.stringify(await lost), /load the page again/);
  assert.equal(made.failures.length, 1);
});
