import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative, resolve } from "node:path";
import { test } from "node:test";

// base <- api <- tooth <- widgets <- features <- app: a layer imports itself and what is left of it.
const kLayers = ["base", "api", "tooth", "widgets", "features", "app"];
const kSource = resolve("src");
// Packages that only some places may know, so that list pages stay small and layers stay honest.
const kPackageHomes: Readonly<Record<string, readonly string[]>> = {
  three: [], // the tests compare with it
  uplot: ["widgets/use_plot.ts"],
  "@tanstack/virtual-core": ["widgets/windowed.tsx"],
  "@preact/signals": ["app"],
};

interface Import {
  readonly from: string; // path under src
  readonly to: string; // as written
  readonly isType: boolean;
  readonly isDynamic: boolean;
}

function sources(folder: string): string[] {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return sources(path);
    return /\.tsx?$/.test(entry.name) && !/\.test\.ts$/.test(entry.name) ? [path] : [];
  });
}

function importsOf(path: string): Import[] {
  const pattern = /(?:import|export)\s+(type\s)?[^;"']*?from\s+"([^"]+)"|import\("([^"]+)"\)|import\s+"([^"]+)"/g;
  return [...readFileSync(path, "utf8").matchAll(pattern)].map((match) => ({
    from: relative(kSource, path),
    to: match[2] ?? match[3] ?? match[4] ?? "",
    isType: match[1] !== undefined,
    isDynamic: match[3] !== undefined,
  }));
}

const imports = sources(kSource).flatMap(importsOf);

function target(item: Import): string | undefined {
  return item.to.startsWith(".") ? relative(kSource, resolve(kSource, dirname(item.from), item.to)) : undefined;
}

test("imports are found at all", () => {
  assert.ok(imports.length > 60, `${imports.length} imports`);
});

test("a layer imports only itself and lower layers", () => {
  for (const item of imports) {
    const to = target(item);
    if (to === undefined || to.startsWith("..")) continue;
    const from = kLayers.indexOf(item.from.split("/")[0]!);
    const layer = kLayers.indexOf(to.split("/")[0]!);
    assert.ok(from >= 0 && layer >= 0, `${item.from} or ${to} is in no layer`);
    assert.ok(layer <= from, `${item.from} imports ${to}, which is above it`);
  }
});

test("features do not import each other", () => {
  for (const item of imports) {
    const [layer, feature] = (target(item) ?? "").split("/");
    const [fromLayer, fromFeature] = item.from.split("/");
    if (layer === "features" && fromLayer === "features")
      assert.equal(feature, fromFeature, `${item.from} imports ${item.to}`);
  }
});

test("only generated API types come from outside src, and only into api/types.ts", () => {
  for (const item of imports) {
    if (target(item)?.startsWith("..") !== true) continue;
    assert.equal(item.from, "api/types.ts");
    assert.ok(item.isType);
  }
});

// The page's end of the worker, and what both show in the same colours.
const kOfThePage = [
  "tooth/canvas_ahead",
  "tooth/link",
  "tooth/start_worker",
  "tooth/deviation_scale",
  "tooth/line_colors",
  "tooth/tissue_color",
];

test("what reads and draws teeth runs in the worker, and the page loads nothing of it", () => {
  for (const item of imports) {
    const to = target(item) ?? "";
    if (!to.startsWith("tooth/") || item.from.startsWith("tooth/") || kOfThePage.includes(to)) continue;
    assert.ok(item.isType, `${item.from} imports ${to}`);
  }
});

test("widgets know no requests and no application state", () => {
  for (const item of imports) {
    if (!item.from.startsWith("widgets/")) continue;
    const to = target(item) ?? "";
    assert.ok(
      !["api/client", "api/http", "api/use_request", "api/use_pages", "api/use_change"].includes(to) || item.isType,
      `${item.from} imports ${to}`,
    );
  }
});

test("three and uplot are loaded only where they are drawn with, and never with the list pages", () => {
  for (const item of imports) {
    for (const [name, homes] of Object.entries(kPackageHomes)) {
      if (item.to !== name && !item.to.startsWith(`${name}/`)) continue;
      assert.ok(
        item.isType || homes.some((home) => item.from === home || item.from.startsWith(`${home}/`)),
        `${item.from} imports ${item.to}`,
      );
      if (name === "uplot") assert.ok(item.isType || item.isDynamic, `${item.from} loads uplot with the page`);
    }
  }
});
