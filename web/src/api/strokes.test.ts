import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { strokesIn } from "./strokes";

interface Track {
  readonly force_n: unknown[];
  readonly ideal_n: unknown[];
  readonly t_s: unknown[];
  readonly figures: { bound: unknown }[];
}
interface Golden {
  format: number;
  devices: { kc_n_per_mm: unknown; readonly cases: readonly { readonly tracks: readonly Track[] }[] }[];
}

const golden = (): Golden => JSON.parse(readFileSync("../schemas/golden/strokes.json", "utf8"));

test("the golden document is read, alone and as a member of a report", () => {
  const alone = strokesIn(golden());
  assert.ok(alone.ok, alone.ok ? "" : alone.error);
  assert.ok(alone.value.devices[0]!.cases.length >= 2);
  assert.deepEqual(strokesIn({ format: 1, rows: [], strokes: golden() }), alone);
});

test("a document that is no strokes document is refused with a reason", () => {
  const refused = (change: (document: Golden) => void): string => {
    const document = golden();
    change(document);
    const result = strokesIn(document);
    assert.equal(result.ok, false);
    return result.ok ? "" : result.error;
  };
  const track = (document: Golden) => document.devices[0]!.cases[0]!.tracks[0]!;
  assert.match(
    refused((d) => {
      d.format = 2;
    }),
    /format 2/,
  );
  assert.match(
    refused((d) => {
      d.devices = [];
    }),
    /found 0/,
  );
  assert.match(
    refused((d) => {
      track(d).force_n.pop();
    }),
    /force_n/,
  );
  assert.match(
    refused((d) => {
      track(d).force_n[0] = "1";
    }),
    /force_n/,
  );
  assert.match(
    refused((d) => {
      track(d).ideal_n[0] = null;
    }),
    /ideal_n/,
  );
  assert.match(
    refused((d) => {
      track(d).t_s.reverse();
    }),
    /time does not grow/,
  );
  assert.match(
    refused((d) => {
      track(d).figures[0]!.bound = "none";
    }),
    /figure/,
  );
  assert.match(
    refused((d) => {
      d.devices[0]!.kc_n_per_mm = undefined;
    }),
    /kc_n_per_mm/,
  );
  for (const other of [undefined, null, 3, "text", [], { rows: [] }]) assert.equal(strokesIn(other).ok, false);
});
