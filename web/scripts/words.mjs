// The catalogues of schemas/words as the page uses them: types of their keys and places into
// build/words.d.ts, and the module "enamel:words", which src/base/words.ts reads. Messages become
// texts with {places}, plurals a list of cases: the page parses nothing and makes no code at run
// time.
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { parse } from "@messageformat/parser";

const kFolder = new URL("../../schemas/words/", import.meta.url);
const kTypes = new URL("../build/words.d.ts", import.meta.url);
export const kLanguages = ["en", "de", "zh"];
const kVersion = 1;

// Messages of the page alone, and those it shares with the station's window.
const kParts = ["page", "exercise"];

export function readCatalogue(language) {
  return Object.assign({}, ...kParts.map((part) => readPart(language, part)));
}

function readPart(language, part) {
  const file = new URL(`${language}/${part}.json`, kFolder);
  if (!existsSync(file))
    throw new Error(
      `expected the page's words at ${fileURLToPath(file)}, found nothing: check out the whole repository`,
    );
  const { version, messages } = JSON.parse(readFileSync(file, "utf8"));
  if (version !== kVersion) throw new Error(`${fileURLToPath(file)}: expected version ${kVersion}, found ${version}`);
  return messages;
}

function compiledTokens(tokens, around, where) {
  const pieces = [];
  const text = (added) => {
    if (typeof pieces.at(-1) === "string") pieces[pieces.length - 1] += added;
    else pieces.push(added);
  };
  for (const token of tokens) {
    if (token.type === "content") text(token.value);
    else if (token.type === "argument") text(`{${token.arg}}`);
    else if (token.type === "octothorpe") text(`{${around}}`);
    else if (token.type === "plural")
      pieces.push([
        token.arg,
        Object.fromEntries(token.cases.map(({ key, tokens: inner }) => [key, compiledTokens(inner, token.arg, where)])),
      ]);
    else throw new Error(`${where}: expected texts, {places} and plurals, found ${token.type}`);
  }
  return pieces.length === 0 ? "" : pieces.length === 1 && typeof pieces[0] === "string" ? pieces[0] : pieces;
}

// A text, or a list of texts and [place, cases].
export function compiled(message, where) {
  return compiledTokens(parse(message), undefined, where);
}

// From the name of each place to "number", where it decides on a plural, or "text".
export function placesOf(message, where) {
  const places = {};
  const visit = (tokens) => {
    for (const token of tokens) {
      if (token.type === "argument") places[token.arg] ??= "text";
      if (token.type !== "plural") continue;
      places[token.arg] = "number";
      for (const { tokens: inner } of token.cases) visit(inner);
    }
  };
  try {
    visit(parse(message));
  } catch (error) {
    throw new Error(`${where}: ${error.message}`);
  }
  return places;
}

// Those that a source names, whole ("place.thing") or by their beginning (`place.${thing}`).
export function keysIn(source, keys) {
  const named = new Set([...source.matchAll(/["'`]([a-z0-9_]+\.[a-z0-9_]+)["'`]/g)].map((match) => match[1]));
  const begun = [...source.matchAll(/`([a-z0-9_]+\.[a-z0-9_]*)\$\{/g)].map((match) => match[1]);
  return keys.filter((key) => named.has(key) || begun.some((start) => key.startsWith(start)));
}

// Types of keys and places. Nothing is written where nothing changed.
export function generateWords() {
  const places = Object.entries(readCatalogue("en")).map(([key, message]) => {
    const names = Object.entries(placesOf(message, key)).map(
      ([name, kind]) => `readonly ${name}: ${kind === "number" ? "number" : "string"}`,
    );
    return `    "${key}": {${names.length === 0 ? "" : ` ${names.join("; ")} `}};`;
  });
  const text = `declare module "enamel:words" {
  export type Cases = { readonly [choice: string]: Message };
  export type Message = string | readonly (string | readonly [string, Cases])[];
  export type Messages = { readonly [key: string]: Message };
  export type Part = "first" | "account_page" | "attempt_page" | "closer" | "compare_search" | "exercise_page" | "staff" | "live" | "more" | "marking" | "editors" | "copy_form" | "my_progress" | "tooth_import" | "target_scan" | "builtin";
  export const kAtOnce: Messages;
  export const kParts: { readonly [language in "en" | "de" | "zh"]: { readonly [part in Part]: () => Promise<{ readonly default: Messages }> } };
  export interface Places {
${places.join("\n")}
  }
}
`;
  if (existsSync(kTypes) && readFileSync(kTypes, "utf8") === text) return;
  mkdirSync(new URL(".", kTypes), { recursive: true });
  writeFileSync(kTypes, text);
}

const kName = /^enamel:words(\/.*)?$/;

function plugin(load, short = new Map(), before = new Map()) {
  return {
    name: "words",
    setup(build) {
      if (short.size > 0)
        build.onLoad({ filter: /\/src\/.*\.tsx?$/ }, ({ path }) => ({
          contents: (before.get(path) ?? "") + shortened(readFileSync(path, "utf8"), short),
          loader: path.endsWith("x") ? "tsx" : "ts",
        }));
      build.onResolve({ filter: kName }, ({ path }) => ({ path, namespace: "words" }));
      build.onLoad({ filter: kName, namespace: "words" }, ({ path }) => ({
        contents: load(path.split("/").slice(1)),
        loader: "js",
      }));
    },
  };
}

const written = (language, keys, short = new Map()) => {
  const messages = readCatalogue(language);
  return JSON.stringify(
    Object.fromEntries(keys.map((key) => [short.get(key) ?? key, compiled(messages[key], `${language} ${key}`)])),
  );
};

const kSaid = /(\bsay(?:With)?(?:<[^(]*>)?\()"([a-z0-9_]+\.[a-z0-9_]+)"/g;

// Names of a few letters for keys that are only ever said as they are written,
// `say("place.thing")`: a third of what the words weigh is their keys. `sources`: of the whole
// page.
export function shortKeys(sources) {
  const all = sources.join("\n");
  const rest = all.replaceAll(kSaid, "");
  const keys = Object.keys(readCatalogue("en"));
  const other = new Set(keysIn(rest, keys));
  const said = new Set([...all.matchAll(kSaid)].map((match) => match[2]));
  return new Map(keys.filter((key) => said.has(key) && !other.has(key)).map((key, i) => [key, i.toString(36)]));
}

const shortened = (source, short) =>
  source.replaceAll(kSaid, (whole, call, key) => (short.has(key) ? `${call}"${short.get(key)}"` : whole));

// English alone, there from the start: for tests, and for what is read without a server. `keys`:
// all where there are none.
export function englishAtOnce(keys = Object.keys(readCatalogue("en"))) {
  return plugin(() => `export const kAtOnce = ${written("en", keys)}; export const kParts = {};`);
}

// Texts of built-in exercises are a separate part: readers of English do not need it.
const kBuiltin = /^builtin_/;
export const pageKeys = () => Object.keys(readCatalogue("en")).filter((key) => !kBuiltin.test(key));
const builtinKeys = () => Object.keys(readCatalogue("en")).filter((key) => kBuiltin.test(key));

// Each part in each language a file of its own, loaded when it is needed. `pageParts`: from its
// name to the keys it needs. `before`: what the build writes before a source.
export function wordsByPart(pageParts, short, before) {
  const parts = { ...pageParts, builtin: builtinKeys() };
  const source = (language, part) =>
    part === "builtin" && language === "en"
      ? "Promise.resolve({ default: {} })"
      : `import("enamel:words/${language}/${part}")`;
  const list = (language) =>
    Object.keys(parts)
      .map((part) => `${part}: () => ${source(language, part)}`)
      .join(", ");
  return plugin(
    ([language, part]) =>
      language === undefined
        ? `export const kAtOnce = {}; export const kParts = { ${kLanguages.map((code) => `${code}: { ${list(code)} }`).join(", ")} };`
        : `export default ${written(language, parts[part], short)};`,
    short,
    before,
  );
}
