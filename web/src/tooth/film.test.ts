import assert from "node:assert/strict";
import { test } from "node:test";
import { decodeDeviation, kNotCompared } from "./deviation";
import { Film, type FilmScreen } from "./film";
import { golden, goldenHead, goldenPart, goldenPlayer, value } from "./golden.test";
import type { Compared, FilmTold } from "./messages";
import { type BlockMesh, ToothMesher } from "./mesher";
import { decodeMesh } from "./part_mesh";

const kStill = -1;
const kEnd = -2;

// A film with one screen. `pause` is called between two slices; `sliceMs` of 0 is a slice for each block.
function opened({ sliceMs = 1e9, pause = async () => {} }: { sliceMs?: number; pause?: () => Promise<void> } = {}) {
  const blocks = new Map<number, BlockMesh>();
  const told: FilmTold[] = [];
  const drawn: (readonly number[])[] = []; // the blocks that were there
  const given: number[] = []; // of how many blocks it knows what shines through them
  let now = 0;
  const film = new Film((message) => told.push(message), {
    pause,
    opener: () => import("./opened"),
    nowMs: () => {
      now += 13 - Math.min(sliceMs, 13);
      return now;
    },
  });
  const screen: FilmScreen = {
    expect: () => {},
    setBlock: (index, mesh) => {
      if (mesh === undefined) blocks.delete(index);
      else blocks.set(index, mesh);
    },
    setBur: () => {},
    setLooks: (looks) => given.push([...blocks.values()].filter((mesh) => looks(mesh) !== undefined).length),
    setOpened: () => {},
    setDetail: () => {},
    drawNow: () => drawn.push([...blocks.keys()]),
  };
  film.attach(screen);
  const of = <Kind extends FilmTold["told"]>(kind: Kind) =>
    told.filter((message): message is Extract<FilmTold, { told: Kind }> => message.told === kind);
  return {
    film,
    blocks,
    drawn,
    given,
    of,
    shown: () => of("shown").map(({ frames }) => frames),
    changing: () => new Map([...blocks].filter(([index]) => index >= 0).sort(([a], [b]) => a - b)),
  };
}

const settled = () =>
  new Promise<void>((resolve) => {
    setTimeout(resolve, 5);
  });

// Gives it the file from `from` to before `to`, in pieces of so many bytes.
async function give({ film }: ReturnType<typeof opened>, from = 0, to = Infinity, piece = 1000) {
  const file = golden("entl");
  for (let at = from; at < Math.min(to, file.byteLength); at += piece)
    await film.take({ ask: "bytes", bytes: file.slice(at, Math.min(at + piece, to)) });
  await settled();
}

// The changing blocks at a moment, made without a film.
async function expected(frames: number, deviation?: ArrayBuffer): Promise<Map<number, BlockMesh>> {
  const player = await goldenPlayer();
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

test("the file shows a coarse tooth first, then the end, and then every moment, however it is cut", async () => {
  const head = await goldenHead();
  for (const piece of [1, 7, 1000, 100_000]) {
    const made = opened();
    const coarse = head.bytes + head.endBytes + head.stillBytes;
    await give(made, 0, coarse - 1, piece);
    assert.deepEqual(made.drawn, []);
    await give(made, coarse - 1, coarse, piece);
    assert.deepEqual(made.drawn, [[kStill, kEnd]]);
    assert.deepEqual(made.blocks.get(kEnd), value(await decodeMesh(await goldenPart("end"), head.grid)));
    await give(made, coarse, head.endsAt, piece);
    assert.deepEqual(made.shown(), [5]);
    assert.deepEqual(made.changing(), await expected(5));
    assert.ok(made.blocks.has(kStill) && !made.blocks.has(kEnd), "the coarse end gave way");
    assert.equal(made.of("whole").length, 0);
    await give(made, head.endsAt, head.fileBytes, piece);
    assert.equal(made.of("whole").length, 1);
    assert.deepEqual(
      made.of("gaps").map(({ segment, ticks }) => [segment, ...ticks]),
      [
        [2, 4],
        [1, 2, 3],
        [0, 0, 1],
      ],
    );
    assert.deepEqual(made.of("failed"), []);
  }
});

test("what shines through is made once nothing moves and what is inside is known", async () => {
  const made = opened();
  await give(made);
  await made.film.rest();
  assert.deepEqual(made.given, []);
  await made.film.take({ ask: "interior", bytes: golden("entb") });
  await settled();
  const all = made.blocks.size;
  assert.deepEqual(made.given, [all]);
  const resting = made.film.rest();
  await made.film.take({ ask: "seek", frames: 2 });
  await resting;
  await made.film.rest();
  assert.equal(made.given.at(-1), made.blocks.size, "of the blocks of that moment too");
});

test("a moment that came and was done meanwhile has what shines through all of its blocks too", async () => {
  let paused = async () => {};
  const made = opened({ sliceMs: 0, pause: () => paused() });
  const shows = async (frames: number) => {
    await made.film.take({ ask: "seek", frames });
    for (let i = 0; i < 100 && made.shown().at(-1) !== frames; ++i) await settled();
    assert.equal(made.shown().at(-1), frames);
  };
  await give(made);
  await made.film.take({ ask: "interior", bytes: golden("entb") });
  await shows(0);
  await made.film.rest();
  assert.equal(made.given.at(-1), made.blocks.size);
  await shows(2);
  let came = false;
  paused = async () => {
    if (came) return;
    came = true;
    await shows(4);
  };
  await made.film.rest();
  assert.ok(came);
  assert.equal(made.given.at(-1), made.blocks.size);
});

test("a wish gives the blocks of that moment, and only then says that it is shown", async () => {
  const made = opened();
  await give(made);
  for (const frames of [2, 0, 4]) {
    await made.film.take({ ask: "seek", frames });
    await settled();
    assert.deepEqual(made.changing(), await expected(frames), `after ${frames} frames`);
    assert.equal(made.shown().at(-1), frames);
  }
  assert.deepEqual(made.shown(), [5, 2, 0, 4]);
});

test("nothing of the coarse tooth goes before all of the fine one is there", async () => {
  const made = opened({ sliceMs: 0, pause: settled });
  await give(made);
  for (let i = 0; i < 40 && made.shown().length === 0; ++i) await settled();
  for (const blocks of made.drawn) {
    const changing = blocks.filter((index) => index >= 0).length;
    assert.equal(blocks.includes(kEnd), changing === 0, `${blocks}`);
  }
});

test("a tooth is where its meshes are", async () => {
  const made = opened();
  await give(made);
  const { extent, detail } = made.of("detail").at(-1)!;
  assert.equal(detail, "fine");
  for (const mm of extent.centreMm.slice(0, 2)) assert.ok(Math.abs(mm) < 0.01, `${extent.centreMm}`);
  assert.ok(Math.abs(extent.radiusMm - 1.43) < 0.6, `${extent.radiusMm}`);
});

test("a wish that is overtaken is left where it is, and the later one is whole", async () => {
  let pauses = 0;
  let wanting = false;
  const made = opened({
    sliceMs: 0,
    pause: async () => {
      if (wanting && ++pauses === 2) void made.film.take({ ask: "seek", frames: 3 });
      await settled();
    },
  });
  await give(made);
  for (let i = 0; i < 40 && made.shown().length === 0; ++i) await settled();
  wanting = true;
  void made.film.take({ ask: "seek", frames: 1 });
  for (let i = 0; i < 40; ++i) await settled();
  assert.deepEqual(made.shown(), [5, 3], "the first was never shown");
  assert.deepEqual(made.changing(), await expected(3));
});

test("every block is meshed in the end, however often requests overtake each other", async () => {
  let pauses = 0;
  const made = opened({
    sliceMs: 0,
    pause: async () => {
      if (++pauses < 60) void made.film.take({ ask: "seek", frames: pauses % 6 });
      await settled();
    },
  });
  await give(made);
  for (let i = 0; i < 300 && pauses < 60; ++i) await settled();
  for (let i = 0; i < 60; ++i) await settled();
  assert.deepEqual(made.changing(), await expected(made.shown().at(-1)!));
});

test("a wish for a part that is not here yet is fulfilled when it is", async () => {
  const head = await goldenHead();
  const made = opened();
  await give(made, 0, head.endsAt);
  await made.film.take({ ask: "seek", frames: 1 });
  await settled();
  assert.deepEqual(made.shown(), [5]);
  await give(made, head.endsAt);
  assert.deepEqual(made.shown(), [5, 1]);
  assert.deepEqual(made.changing(), await expected(1));
});

test("the golden deviation is what the document says, and is at the vertices of its cells", async () => {
  const { bricks, values } = value(await decodeDeviation(golden("endv")));
  const made = opened();
  await give(made);
  await made.film.take({ ask: "seek", frames: 2 });
  await settled();
  await made.film.take({ ask: "deviation", bytes: golden("endv") });
  await settled();
  const compared = value(made.of("compared")[0]!.compared) as Compared;
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
  assert.deepEqual(made.changing(), await expected(2, golden("endv")), "what was shown still is, with the deviation");
  await made.film.take({ ask: "seek", frames: 5 });
  await settled();
  assert.deepEqual(made.changing(), await expected(5, golden("endv")));
});

test("a deviation that comes while a moment is made does not change which moment", async () => {
  let compared = false;
  const made = opened({
    sliceMs: 0,
    pause: async () => {
      if (!compared && made.of("whole").length === 1) {
        compared = true;
        void made.film.take({ ask: "deviation", bytes: golden("endv") });
      }
      await settled();
    },
  });
  const { endsAt } = await goldenHead();
  await give(made, 0, endsAt);
  await made.film.take({ ask: "seek", frames: 2 });
  void give(made, endsAt);
  for (let i = 0; i < 100; ++i) await settled();
  assert.equal(made.shown().at(-1), 2);
  assert.deepEqual(made.changing(), await expected(2, golden("endv")));
});

test("damaged files are reported, and nothing is thrown", async () => {
  const made = opened();
  await made.film.take({ ask: "bytes", bytes: golden("entb") });
  assert.match(JSON.stringify(made.of("failed")), /begins with ENTT/);
  const other = opened();
  await give(other);
  await other.film.take({ ask: "deviation", bytes: golden("endv").slice(0, 200) });
  assert.match(JSON.stringify(other.of("compared")), /ends early/);
  for (let end = 0; end < golden("endv").byteLength; ++end)
    assert.equal((await decodeDeviation(golden("endv").slice(0, end))).ok, false, `${end} bytes`);
  const { bytes } = await goldenHead();
  const third = opened();
  const file = new Uint8Array(golden("entl"));
  file[bytes + 20]! ^= 0xff;
  await third.film.take({ ask: "bytes", bytes: file.buffer });
  await settled();
  assert.equal(third.of("failed").length, 1);
});
