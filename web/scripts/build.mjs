// Builds the page: dist/index.html, dist/assets/* with hashed names, .gz and .br beside each; and
// dist_lab, what draws a report of enamel-lab.
//   node scripts/build.mjs [--out DIR]
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, readdirSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { basename, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import { build } from "esbuild";
import { bundleReport } from "./bundle_report.mjs";
import { generate } from "./generate.mjs";
import { keysIn, pageKeys, shortKeys, wordsByPart } from "./words.mjs";

const web = fileURLToPath(new URL("..", import.meta.url));
const kCompressible = /\.(html|js|css|svg|json|txt)$/;
const kMinimumCompressed = 512;
const kMain = "src/app/main.tsx";
const kBegin = "src/app/begin.ts";

function outputFolder(args) {
  const at = args.indexOf("--out");
  if (at < 0) return join(web, "dist");
  if (args[at + 1] === undefined) throw new Error("--out expects a folder");
  return resolve(args[at + 1]);
}

function filesUnder(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    return entry.isDirectory() ? filesUnder(path) : [path];
  });
}

// Never replaces a folder that holds something other than a build of the page.
function mayBeReplaced(folder) {
  if (!existsSync(folder)) return;
  const entries = readdirSync(folder);
  if (entries.length > 0 && !entries.includes("index.html")) {
    throw new Error(
      `expected an empty folder or an earlier build at ${folder}, found other files: name another with --out`,
    );
  }
}

// The new page takes the place of the old one when it is whole: a server that starts meanwhile
// finds one or the other.
function replace(folder, built) {
  rmSync(folder, { recursive: true, force: true });
  renameSync(built, folder);
}

// Returns for each entry the files that it has become: its own, and those that it loads at once.
async function scripts(out, entryPoints, options) {
  const result = await build({
    absWorkingDir: web,
    entryPoints,
    outdir: join(out, "assets"),
    entryNames: "[name]-[hash]",
    chunkNames: "[name]-[hash]",
    assetNames: "[name]-[hash]",
    bundle: true,
    format: "esm",
    target: "es2022",
    minify: true,
    legalComments: "none",
    metafile: true,
    logLevel: "warning",
    ...options,
  });
  const { outputs } = result.metafile;
  const withImports = (path) => {
    const seen = new Set([path]);
    for (const each of seen)
      for (const item of outputs[each].imports)
        if (item.kind === "import-statement" && item.external !== true) seen.add(item.path);
    return [...seen].map((each) => basename(each));
  };
  const entries = {};
  for (const [path, output] of Object.entries(outputs)) {
    if (output.entryPoint !== undefined) entries[output.entryPoint] = withImports(path);
  }
  return entries;
}

const pageSources = () =>
  filesUnder(join(web, "src"))
    .filter((path) => /\.tsx?$/.test(path) && !/\.test\.ts$/.test(path))
    .map((path) => readFileSync(path, "utf8"));

// What a script loads at once, of our own sources.
function loadedWith(inputs, entry) {
  const seen = new Set([entry]);
  for (const path of seen)
    for (const item of inputs[path].imports)
      if (item.kind === "import-statement" && item.path in inputs) seen.add(item.path);
  return [...seen].filter((path) => path.startsWith("src/"));
}

// The page's sources by the part that needs them: the first, which is loaded before anybody signs in, and each that
// is loaded when somebody comes to it.
async function sourcesOfParts(options, fromBegin) {
  const { metafile } = await build({
    ...options,
    entryPoints: [kMain],
    bundle: true,
    outdir: "unused",
    splitting: true,
    format: "esm",
    metafile: true,
    write: false,
    absWorkingDir: web,
    logLevel: "silent",
    plugins: [fromBegin, wordsByPart({})],
  });
  const lazy = Object.values(metafile.inputs).flatMap((input) =>
    input.imports
      .filter((item) => item.kind === "dynamic-import" && item.path.startsWith("src/") && item.path.endsWith(".tsx"))
      .map((item) => item.path),
  );
  return {
    first: loadedWith(metafile.inputs, kMain),
    lazy: new Map([...new Set(lazy)].map((entry) => [entry, loadedWith(metafile.inputs, entry)])),
  };
}

// Which words each part needs: the first those of all its sources, each other what its own name beyond.
function wordsOfParts({ first, lazy }) {
  const keys = pageKeys();
  const named = (sources) => new Set(sources.flatMap((path) => keysIn(readFileSync(join(web, path), "utf8"), keys)));
  const firstKeys = named(first);
  const parts = { first: [...firstKeys] };
  for (const [entry, sources] of lazy)
    parts[basename(entry, ".tsx")] = [...named(sources)].filter((key) => !firstKeys.has(key));
  return parts;
}

// The build makes a file of all sources that the same parts need. A file more costs a request and its head, which for a
// small one is more than its content. So each part names all that the first has, and all that several have: that makes
// two files. By path, what is written before a part's source.
function inTwoFiles({ first, lazy }) {
  const uses = [...lazy.values()].flat();
  const several = new Set(uses.filter((path, i) => !first.includes(path) && uses.indexOf(path) !== i));
  const imports = [...first.filter((path) => path !== kMain), ...several]
    .filter((path) => !lazy.has(path))
    .map((path) => `import ${JSON.stringify(join(web, path))};`)
    .join("");
  return new Map([...lazy.keys()].map((entry) => [join(web, entry), imports]));
}

// The worker first, and whole in one file: the page must know its name, and it imports nothing from
// elsewhere. Before it what it loads for sections, whole as well: parts that both have would be a file more to wait for.
// The page's first script is whole for the same reason.
async function bundle(out) {
  const [kWorker, kOpened] = ["src/tooth/worker.ts", "src/tooth/opened.ts"];
  const address = (entries, source) => JSON.stringify(`/assets/${entries[source][0]}`);
  const opened = await scripts(out, [kOpened], {});
  const worker = await scripts(out, [kWorker], {
    define: { kOpenedAddress: address(opened, kOpened) },
    external: ["/assets/*"],
  });
  const begin = await scripts(out, [kBegin], { define: { kToothWorkerAddress: address(worker, kWorker) } });
  const options = { splitting: true, jsx: "automatic", jsxImportSource: "preact" };
  const fromBegin = {
    name: "begin",
    setup: ({ onResolve }) =>
      onResolve({ filter: /^\.\/begin$/ }, () => ({ path: `/assets/${begin[kBegin][0]}`, external: true })),
  };
  const sources = await sourcesOfParts(options, fromBegin);
  const page = await scripts(
    out,
    { app: kMain, style: "src/app/style.css" },
    {
      ...options,
      plugins: [fromBegin, wordsByPart(wordsOfParts(sources), shortKeys(pageSources()), inTwoFiles(sources))],
    },
  );
  return { ...page, ...begin };
}

// Everything under assets/ is cached for ever, so every name there changes with the content.
function copyHashed(name, extension, out) {
  const bytes = readFileSync(join(web, "public", name + extension));
  const hashed = `${name}-${createHash("sha256").update(bytes).digest("hex").slice(0, 8).toUpperCase()}${extension}`;
  writeFileSync(join(out, "assets", hashed), bytes);
  return hashed;
}

// All that the first script needs is named here, so that it comes with it and not after it; and what a part needs
// (widgets/part.tsx). `soon`: the part that every address with this page shows.
function indexHtml(entries, icon, soon) {
  const [script, ...first] = entries[kMain];
  const loaded = [...first, ...(soon === undefined ? [] : entries[soon])].filter((file) => file !== script);
  const ahead = [...new Set(loaded)].map((file) => `<link rel="modulepreload" href="/assets/${file}">\n`).join("");
  const parts = Object.entries(entries)
    .filter(([entry]) => entry.startsWith("src/") && entry.endsWith(".tsx") && entry !== kMain)
    .map(([entry, files]) => [basename(entry, ".tsx"), files.filter((file) => !entries[kMain].includes(file))])
    .map(
      ([part, files]) => `<meta name="part-${part}" content="${files.map((file) => `/assets/${file}`).join(" ")}">\n`,
    )
    .join("");
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta name="description" content="Exercises, attempts and scores of haptic tooth preparation">
<title>Enamel</title>
<link rel="icon" href="/assets/${icon}" type="image/svg+xml">
<link rel="stylesheet" href="/assets/${entries["src/app/style.css"][0]}">
<script type="module" async src="/assets/${entries[kBegin][0]}"></script>
<script type="module" src="/assets/${script}"></script>
${ahead}${parts}</head>
<body>
<div id="app"></div>
<noscript>Enamel needs JavaScript: allow it for this address and load the page again.</noscript>
</body>
</html>
`;
}

function compress(path) {
  const bytes = readFileSync(path);
  if (!kCompressible.test(path) || bytes.length < kMinimumCompressed) return;
  writeFileSync(`${path}.gz`, gzipSync(bytes, { level: 9 }));
  writeFileSync(
    `${path}.br`,
    brotliCompressSync(bytes, {
      params: { [constants.BROTLI_PARAM_QUALITY]: 11, [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length },
    }),
  );
}

function report(out) {
  for (const path of filesUnder(out)
    .filter((file) => kCompressible.test(file))
    .sort()) {
    const gz = `${path}.gz`;
    const size = readFileSync(path).length;
    const packed = existsSync(gz) ? readFileSync(gz).length : size;
    console.log(
      `${relative(out, path).padEnd(36)} ${(size / 1000).toFixed(1).padStart(8)} kB ${(packed / 1000).toFixed(1).padStart(8)} kB gz`,
    );
  }
}

await generate();
await bundleReport();
const folder = outputFolder(process.argv.slice(2));
mayBeReplaced(folder);
const out = `${folder}.new`;
rmSync(out, { recursive: true, force: true });
mkdirSync(join(out, "assets"), { recursive: true });
const entries = await bundle(out);
const icon = copyHashed("favicon", ".svg", out);
writeFileSync(join(out, "index.html"), indexHtml(entries, icon));
mkdirSync(join(out, "attempts"));
writeFileSync(join(out, "attempts/index.html"), indexHtml(entries, icon, "src/features/attempt/attempt_page.tsx"));
for (const path of filesUnder(out)) compress(path);
report(out);
replace(folder, out);
