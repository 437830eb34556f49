import assert from "node:assert/strict";
import { test } from "node:test";
import { keepQueue, placeInQueue } from "./queue";

function storage(text?: string) {
  let kept: string | null = text ?? null;
  return {
    getItem: () => kept,
    setItem: (_key: string, value: string) => {
      kept = value;
    },
  };
}

test("an attempt of the queue knows its place, the previous and the next one", () => {
  const kept = storage();
  keepQueue({ back: "/grading?assignment=x", ids: ["a", "b", "c"] }, kept);
  assert.deepEqual(placeInQueue("b", kept), {
    back: "/grading?assignment=x",
    number: 2,
    count: 3,
    previous: "a",
    next: "c",
  });
  assert.equal(placeInQueue("a", kept)?.previous, undefined);
  assert.equal(placeInQueue("c", kept)?.next, undefined);
  assert.equal(placeInQueue("d", kept), undefined);
});

test("what is no queue, or leads elsewhere, is none", () => {
  for (const text of [
    "",
    "null",
    "[]",
    "{",
    '{"back":"//evil","ids":["a"]}',
    '{"back":"https://x","ids":["a"]}',
    '{"back":"/x","ids":[1]}',
    '{"back":"/x"}',
  ])
    assert.equal(placeInQueue("a", storage(text)), undefined, text);
});

test("a browser that keeps nothing is no error", () => {
  const full = {
    getItem: () => {
      throw new Error("denied");
    },
    setItem: () => {
      throw new Error("full");
    },
  };
  keepQueue({ back: "/x", ids: ["a"] }, full);
  assert.equal(placeInQueue("a", full), undefined);
});
