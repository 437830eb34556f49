import assert from "node:assert/strict";
import { test } from "node:test";
import { commentsOf, dropComment, keepComment } from "./comment_bank";

function storage() {
  const kept = new Map<string, string>();
  return {
    kept,
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
  };
}

test("a kept comment comes first, once, and for its person alone", () => {
  const place = storage();
  keepComment("a", "Too deep.", place);
  keepComment("a", "Good.", place);
  assert.deepEqual(keepComment("a", " Too deep. ", place), ["Too deep.", "Good."]);
  assert.deepEqual(commentsOf("b", place), []);
  assert.deepEqual(dropComment("a", "Good.", place), ["Too deep."]);
});

test("many comments stay few, and what is no list of texts is none", () => {
  const place = storage();
  for (let i = 0; i < 60; ++i) keepComment("a", `text ${i}`, place);
  assert.equal(commentsOf("a", place).length, 40);
  assert.equal(commentsOf("a", place)[0], "text 59");
  for (const text of ["{", "null", '{"a":1}', "[1,null]"]) {
    place.kept.set("enamel.comments.a", text);
    assert.deepEqual(commentsOf("a", place), [], text);
  }
});
