import assert from "node:assert/strict";
import { test } from "node:test";
import { draftOf, draftsOf, eraseDrafts, keepDraft } from "./drafts";

function storage() {
  const kept = new Map<string, string>();
  return {
    kept,
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
}

test("a draft belongs to its person and its field, until it is emptied or the person signs out", () => {
  const place = storage();
  draftsOf("a");
  keepDraft("remark 1", { text: "Too deep.", point: [1, 2, 3], seconds: 4.5 }, place);
  keepDraft("remark 2", { text: "Good." }, place);
  assert.deepEqual(draftOf("remark 1", place), { text: "Too deep.", point: [1, 2, 3], seconds: 4.5 });
  draftsOf("b");
  assert.equal(draftOf("remark 1", place), undefined);
  draftsOf("a");
  keepDraft("remark 1", { text: " " }, place);
  assert.equal(draftOf("remark 1", place), undefined);
  assert.equal(draftOf("remark 2", place)?.text, "Good.");
  eraseDrafts(place);
  assert.equal(place.kept.size, 0);
});

test("the hundred newest drafts are kept, and what is no draft is passed over", () => {
  const place = storage();
  draftsOf("a");
  for (let i = 0; i < 120; ++i) keepDraft(`remark ${i}`, { text: "x" }, place);
  assert.equal(draftOf("remark 19", place), undefined);
  assert.equal(draftOf("remark 20", place)?.text, "x");
  place.setItem(
    "enamel.drafts.a",
    '[["a", {"text": 1}], ["b"], 7, ["c", {"text": "y", "point": [1, 2]}], ["d", {"text": "z"}]]',
  );
  assert.deepEqual(
    ["a", "b", "c", "d"].map((name) => draftOf(name, place)?.text),
    [undefined, undefined, undefined, "z"],
  );
});

test("a browser that keeps nothing has no drafts", () => {
  const fail = () => {
    throw new Error("refused");
  };
  const place = { getItem: fail, setItem: fail, removeItem: fail };
  keepDraft("remark 1", { text: "x" }, place);
  eraseDrafts(place);
  assert.equal(draftOf("remark 1", place), undefined);
});
