import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { afterEach, test } from "node:test";
import { kLanguages, speak } from "../base/language";
import { nameOf, numbersOf, sentencesOf, wordedText, wordedTitle } from "./builtin_words";

// All that is built in: tests/common/scene/words_test.cpp writes it down.
const lines = readFileSync("../schemas/golden/builtin_words.txt", "utf8")
  .split("\n")
  .filter((line) => line !== "");
const titles = lines.filter((line) => line.startsWith("title ")).map((line) => line.slice("title ".length));
const sentences = [
  ...new Set(
    lines.filter((line) => line.startsWith("text ")).flatMap((line) => sentencesOf(line.slice("text ".length))),
  ),
];
const messagesOf = (language: string) =>
  (
    JSON.parse(readFileSync(`../schemas/words/${language}/exercise.json`, "utf8")) as {
      readonly messages: Readonly<Record<string, string>>;
    }
  ).messages;
const english = messagesOf("en");
const builtIn = new Map<string, string>([
  ...titles.map((title) => [`builtin_title.${nameOf(title)}`, title] as const),
  ...sentences.map((sentence) => [`builtin_text.${nameOf(sentence)}`, sentence] as const),
]);

afterEach(() => speak("en"));

test("every built-in title and sentence has its message, which is the same in English", () => {
  assert.ok(titles.length > 0 && sentences.length > 0, `${titles.length} titles and ${sentences.length} sentences`);
  const filled = (message: string, text: string) =>
    Object.entries(numbersOf(text)).reduce((now, [place, value]) => now.replace(`{${place}}`, value), message);
  for (const [key, text] of builtIn) {
    assert.ok(english[key] !== undefined, `no ${key} in schemas/words/*/exercise.json: ${text}`);
    const grouped = filled(english[key], text); // thousands, as the language does
    assert.equal(grouped.replaceAll(/(?<=\d)\u202f(?=\d)/g, ""), text.replaceAll("'", "’"), key);
  }
});

test("every language says it in words of its own", () => {
  for (const { code } of kLanguages.filter((language) => language.code !== "en")) {
    const messages = messagesOf(code);
    for (const key of builtIn.keys()) assert.notEqual(messages[key], english[key], `${code} ${key}`);
  }
});

test("no message is left of what is no longer built in", () => {
  assert.deepEqual(
    Object.keys(english).filter((key) => /^builtin_(title|text)\./.test(key) && !builtIn.has(key)),
    [],
  );
});

test("what a school has written stays as it was typed", () => {
  speak("de");
  for (const text of ["Prepare like Monday's patient", "Do not expose the pulp. Ask Dr Lee first.", ""]) {
    assert.equal(wordedTitle(text), text);
    assert.equal(wordedText(text), text);
  }
});

test("a built-in text is said sentence by sentence with its own numbers", () => {
  speak("de");
  // The tests have the English messages alone: their numbers are written as German has them.
  assert.equal(
    wordedText("Take 1.2 mm off the incisal edge. Do not touch the root."),
    "Take 1,2 mm off the incisal edge. Do not touch the root.",
  );
  assert.equal(wordedTitle("Line, 8 x 1.5 mm and 2.0 mm deep"), "Line, 8 x 1,5 mm and 2,0 mm deep");
  speak("zh");
  assert.equal(
    wordedText("Do not expose the pulp. Do not touch the root."),
    "Do not expose the pulp.Do not touch the root.",
  );
});

function sources(folder: string): string[] {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return sources(path);
    return /\.tsx?$/.test(entry.name) && !/\.test\.ts$/.test(entry.name) ? [path] : [];
  });
}

// A file for other programs has them as the server gives them.
const kUnworded = ["src/features/cohorts/grades.ts"];

test("no title or instruction of an exercise is shown without its words", () => {
  const bare = sources("src")
    .filter((path) => !kUnworded.includes(path))
    .flatMap((path) =>
      readFileSync(path, "utf8")
        .split("\n")
        .filter((line) =>
          /\bexercise\.(?:title(?! === null)|instructions)\b/.test(
            line.replaceAll(/worded(?:Title|Text)\([^()]*\)/g, ""),
          ),
        )
        .map((line) => `${path}: ${line.trim()}`),
    );
  assert.deepEqual(bare, []);
});
