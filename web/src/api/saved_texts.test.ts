import assert from "node:assert/strict";
import { test } from "node:test";
import type { SavedText } from "../api/types";
import { foundIn, ownFirst, withText } from "./saved_texts";

const saved = (text: string, mine: boolean): SavedText => ({
  id: text,
  owner: { id: "p", display_name: mine ? "Ada" : "Ben Núñez" },
  text,
  shared: !mine,
  saved_ms: 1,
  mine,
  may_change: mine,
  revision: 1,
});
const texts = [saved("Too deep.", false), saved("Wall leans.", true), saved("Too rough.", true)];
const shown = (rows: readonly SavedText[]) => rows.map(({ text }) => text);

test("one's own texts come before those that others share, in the server's order", () => {
  assert.deepEqual(shown(ownFirst(texts)), ["Wall leans.", "Too rough.", "Too deep."]);
});

test("a text is found by words of it or of its owner's name", () => {
  assert.deepEqual(shown(foundIn(texts, "TOO")), ["Too deep.", "Too rough."]);
  assert.deepEqual(shown(foundIn(texts, "deep núñez")), ["Too deep."]);
  assert.deepEqual(shown(foundIn(texts, " ")), shown(texts));
});

test("a saved text comes after what is written", () => {
  assert.equal(withText(" ", "Too deep."), "Too deep.");
  assert.equal(withText("Look: \n", "Too deep."), "Look: Too deep.");
});
