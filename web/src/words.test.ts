import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import ts from "typescript";
import { keysIn, kLanguages, placesOf } from "../scripts/words.mjs";

// The catalogues of schemas/words hold all that the page says: schemas/words.md.

const partOf = (language: string, part: string) =>
  (
    JSON.parse(readFileSync(`../schemas/words/${language}/${part}.json`, "utf8")) as {
      readonly messages: Readonly<Record<string, string>>;
    }
  ).messages;
const messagesOf = (language: string) => ({ ...partOf(language, "page"), ...partOf(language, "exercise") });
const catalogues = Object.fromEntries(kLanguages.map((language) => [language, messagesOf(language)])) as Readonly<
  Record<(typeof kLanguages)[number], Readonly<Record<string, string>>>
>;
const keys = Object.keys(catalogues.en);

function sources(folder: string): string[] {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return sources(path);
    return /\.tsx?$/.test(entry.name) && !/\.test\.ts$/.test(entry.name) ? [path] : [];
  });
}
const files = sources("src").map((path) => ({ path, text: readFileSync(path, "utf8") }));

test("every language has the same keys, in order, and every key is well formed", () => {
  assert.ok(keys.length > 100, `${keys.length} keys`);
  for (const language of kLanguages) {
    for (const part of ["page", "exercise"])
      assert.deepEqual(
        Object.keys(partOf(language, part)),
        Object.keys(partOf("en", part)).sort(),
        `${language} ${part}`,
      );
  }
  for (const key of keys) assert.match(key, /^[a-z0-9_]+\.[a-z0-9_]+$/);
});

test("no two parts have the same key", () => {
  assert.equal(keys.length, Object.keys(partOf("en", "page")).length + Object.keys(partOf("en", "exercise")).length);
  for (const part of ["window", "faults"]) {
    assert.deepEqual(
      keys.filter((key) => Object.hasOwn(partOf("en", part), key)),
      [],
      part,
    );
  }
});

test("every message is one, with the same places in every language and no apostrophe that ICU would swallow", () => {
  for (const language of kLanguages) {
    for (const [key, message] of Object.entries(catalogues[language])) {
      assert.notEqual(message, "", `${language} ${key}`);
      assert.doesNotMatch(message, /'/, `${language} ${key}`);
      assert.deepEqual(sortedPlaces(language, key), sortedPlaces("en", key), `${language} ${key}`);
    }
  }
});

// Sorted, with the kind of each. The code's sentence of an error may do without the server's.
function sortedPlaces(language: (typeof kLanguages)[number], key: string): string[] {
  const places = placesOf(catalogues[language][key]!, `${language} ${key}`);
  if (key.startsWith("error_code.")) delete places["said"];
  return Object.entries(places)
    .map(([name, kind]) => `${name}: ${kind}`)
    .sort();
}

test("a plural has the cases that its language needs", () => {
  for (const language of kLanguages) {
    const needed = new Intl.PluralRules(language).resolvedOptions().pluralCategories;
    for (const [key, message] of Object.entries(catalogues[language])) {
      for (const [, cases = ""] of message.matchAll(/\{\w+, plural, ((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}/g)) {
        const named = [...cases.matchAll(/(=\d+|\w+) \{/g)].map((match) => match[1]!);
        assert.ok(named.includes("other"), `${language} ${key}`);
        // Where all cases read alike one is enough.
        if (named.length > 1)
          for (const category of needed) assert.ok(named.includes(category), `${language} ${key} has no ${category}`);
      }
    }
  }
});

test("every key is said somewhere", () => {
  const all = files.map(({ text }) => text).join("\n");
  const said = new Set(keysIn(all, keys));
  assert.deepEqual(
    keys.filter((key) => !said.has(key)),
    [],
  );
});

test("nothing is said while a file is loaded, before its words are there", () => {
  const early: string[] = [];
  for (const { path, text } of files) {
    const source = ts.createSourceFile(path, text, ts.ScriptTarget.Latest, true);
    const visit = (node: ts.Node): void => {
      if (ts.isFunctionLike(node)) return;
      if (ts.isCallExpression(node) && /^say(With|If|IfWith)?$/.test(node.expression.getText(source)))
        early.push(`${path}: ${node.getText(source)}`);
      ts.forEachChild(node, visit);
    };
    visit(source);
  }
  assert.deepEqual(early, []);
});

// What has no other form in other languages.
const kNoWords = /^(?:Enamel|English|Deutsch|中文|Ctrl\+[A-Z]|CSV|JSON|WebGL|N|s|mm|min|kB|B|MB|GB|%|°|X|Y|Z|A|B)$/;
const kAlwaysRead = new Set(["label", "title", "aria-label", "placeholder", "alt", "hint"]);
const kShown = new Set([
  "label",
  "title",
  "aria-label",
  "placeholder",
  "alt",
  "hint",
  "legend",
  "action",
  "what",
  "empty",
  "message",
  "document",
  "aria-roledescription",
  "valueTitle",
]);

const kGivesAText = new Set<ts.SyntaxKind>([
  ts.SyntaxKind.PlusToken,
  ts.SyntaxKind.AmpersandAmpersandToken,
  ts.SyntaxKind.BarBarToken,
  ts.SyntaxKind.QuestionQuestionToken,
]);

function hasWords(text: string): boolean {
  const trimmed = text.replaceAll(/&\w+;/g, " ").trim();
  return /\p{L}{2}/u.test(trimmed) && !kNoWords.test(trimmed);
}

// A literal that becomes text of the page wherever it stands: an element's text, an attribute that
// is read or heard, a member of that name, and what such a place chooses from.
function ownWords(path: string, text: string): string[] {
  const source = ts.createSourceFile(path, text, ts.ScriptTarget.Latest, true);
  const found: string[] = [];
  const told = (node: ts.Node, words: string) => {
    if (hasWords(words))
      found.push(`${path}:${source.getLineAndCharacterOfPosition(node.getStart(source)).line + 1}: ${words.trim()}`);
  };
  // A small word by itself names a case where the place is not always one that is read.
  const read = (name: string, node: ts.Expression | undefined) => {
    if (node !== undefined && ts.isStringLiteral(node) && /^[a-z_]+$/.test(node.text) && !kAlwaysRead.has(name)) return;
    literals(node);
  };
  const literals = (node: ts.Expression | undefined): void => {
    if (node === undefined) return;
    if (ts.isStringLiteralLike(node)) told(node, node.text);
    else if (ts.isTemplateExpression(node))
      told(node, [node.head.text, ...node.templateSpans.map((span) => span.literal.text)].join(" "));
    else if (ts.isConditionalExpression(node)) [node.whenTrue, node.whenFalse].forEach(literals);
    else if (ts.isBinaryExpression(node) && kGivesAText.has(node.operatorToken.kind))
      [node.left, node.right].forEach(literals);
    else if (ts.isParenthesizedExpression(node)) literals(node.expression);
  };
  // Text that is typed or named literally.
  const isCode = (node: ts.Node) =>
    ts.isJsxElement(node) && ["code", "kbd"].includes(node.openingElement.tagName.getText(source));
  const visit = (node: ts.Node): void => {
    if (isCode(node)) return;
    if (ts.isJsxText(node)) told(node, node.text);
    if (ts.isJsxExpression(node) && !ts.isJsxAttribute(node.parent)) literals(node.expression);
    if (ts.isJsxAttribute(node) && kShown.has(node.name.getText(source)) && node.initializer !== undefined) {
      read(
        node.name.getText(source),
        ts.isJsxExpression(node.initializer)
          ? node.initializer.expression
          : ts.isStringLiteral(node.initializer)
            ? node.initializer
            : undefined,
      );
    }
    if (ts.isPropertyAssignment(node) && kShown.has(node.name.getText(source)))
      read(node.name.getText(source), node.initializer);
    ts.forEachChild(node, visit);
  };
  visit(source);
  return found;
}

test("words of a source's own are found", () => {
  const find = (text: string) => ownWords("x.tsx", `const a = ${text};`).length;
  for (const text of [
    "<p>Some words</p>",
    '<p title="Words" />',
    // biome-ignore lint/suspicious/noTemplateCurlyInString: the placeholder belongs to the checked source
    "<p aria-label={`${n} words`} />",
    '<p>{on ? "yes" : "no"}</p>',
    '({ title: "Words" })',
    '<p>{on && "words"}</p>',
    '<Field hint={"Some " + what} />',
  ])
    assert.ok(find(text) > 0, text);
  for (const text of [
    "<p>Enamel</p>",
    '<p class="words" />',
    '<p>{say("a.b")}</p>',
    '({ key: "words" })',
    "<p>{n} %</p>",
    '<p title={say("a.b")} />',
  ])
    assert.equal(find(text), 0, text);
});

test("no source of the page has words of its own", () => {
  assert.deepEqual(
    files.filter(({ path }) => !kEnglish.has(path)).flatMap(({ path, text }) => ownWords(path, text)),
    [],
  );
});

// What draws a report of the lab, whose texts are English: schemas/words.md.
const kEnglish = new Set(["src/api/lab_report.ts", "src/app/report.tsx"]);

function serverSources(folder: string): string[] {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return serverSources(path);
    return entry.name.endsWith(".cpp") ? [readFileSync(path, "utf8")] : [];
  });
}

test("whatever the server writes into the audit trail is told in words", () => {
  const written = serverSources("../server");
  const found = (pattern: RegExp) =>
    new Set(written.flatMap((text) => [...text.matchAll(pattern)].map(([, name = ""]) => name)));
  const actions = found(/(?:WriteAudit|WriteAuditAbout|NoteAudit)\([^;]*?"([a-z_]+\.[a-z_]+)"/g);
  assert.ok(actions.size > 40, `${actions.size} actions`);
  const actors = found(/Actor\{\{\}, "([a-z' ]+[a-z])"/g);
  assert.ok(actors.size > 3, `${actors.size} actors`);
  const members = found(/JsonOf\(\{\{\s*"([a-z_]+)",/g);
  // As text: R"({"address":")"
  for (const name of found(/[{,]"([a-z_]+)":"\)"/g)) members.add(name);
  assert.ok(members.size > 10, `${members.size} first members`);
  const untold = [
    ...[...actions].map((action) => `audit_action.${action.replace(".", "_")}`),
    ...[...actors].map((actor) => `audit_actor.${actor.replaceAll(/[^a-z]+/g, "_")}`),
    ...[...members].map((member) => `audit_member.${member.replace(/_ms$/, "")}`),
  ].filter((key) => !keys.includes(key));
  assert.deepEqual(untold, []);
});
