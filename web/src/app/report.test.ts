import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";

const kGolden = readFileSync("../schemas/golden/strokes.json", "utf8");

function inFolder(use: (folder: string) => void): void {
  const folder = mkdtempSync(join(tmpdir(), "draw-report-"));
  try {
    use(folder);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

function draw(from: string, to: string): { readonly status: number | null; readonly said: string } {
  const { status, stderr } = spawnSync(process.execPath, ["scripts/draw_report.mjs", from, to], { encoding: "utf8" });
  return { status, said: stderr };
}

test("a report with strokes becomes a page", () =>
  inFolder((folder) => {
    const to = join(folder, "page.html");
    assert.deepEqual(draw("../schemas/golden/strokes.json", to), { status: 0, said: "" });
    assert.ok(statSync(to).size > kGolden.length / 2);
  }));

test("a report with nothing to draw is refused in one sentence and no page is written", () =>
  inFolder((folder) => {
    const [from, to] = [join(folder, "report.json"), join(folder, "page.html")];
    const golden = () =>
      JSON.parse(kGolden) as { format: number; devices: { cases: { tracks: { figures: unknown[] }[] }[] }[] };
    const newer = golden();
    newer.format = 99;
    const noFigure = golden();
    noFigure.devices[0]!.cases[0]!.tracks[0]!.figures[0] = null;
    const reports: readonly (readonly [unknown, RegExp])[] = [
      [{ ...golden(), devices: [] }, /expected 1 to 32 devices, found 0/],
      [{ ...golden(), devices: [1, null, {}] }, /no name/],
      [[1, null, {}], /no JSON object/],
      [newer, /format 99/],
      [noFigure, /figure cannot be read/],
      [{ feel: [] }, /holds no strokes/],
    ];
    for (const [report, why] of reports) {
      writeFileSync(from, JSON.stringify(report));
      const { status, said } = draw(from, to);
      assert.equal(status, 1, said);
      assert.match(said, why);
      assert.match(said, /^[^\n]*report\.json: expected [^\n]*; write one with enamel-lab qualify [^\n]*\n$/);
      assert.ok(!existsSync(to));
    }
  }));

test("a path that cannot be read or written is refused in words", () =>
  inFolder((folder) => {
    const golden = "../schemas/golden/strokes.json";
    const cases: readonly (readonly [string, string, RegExp])[] = [
      [join(folder, "none.json"), join(folder, "page.html"), /found nothing there; write one with/],
      [folder, join(folder, "page.html"), /found a folder; write one with/],
      [golden, folder, /found a folder; name another/],
      [golden, join(folder, "none", "page.html"), /found no such folder; name another/],
    ];
    for (const [from, to, why] of cases) {
      const { status, said } = draw(from, to);
      assert.equal(status, 1, said);
      assert.match(said, why);
      assert.doesNotMatch(said, /ENOENT|EISDIR/);
    }
    assert.ok(!existsSync(join(folder, "page.html")));
  }));
