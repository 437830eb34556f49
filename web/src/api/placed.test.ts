import assert from "node:assert/strict";
import { test } from "node:test";
import { placedMessage, plainMessage } from "./placed";

test("a place is named once, in words where there are some, and bounds are plain numbers", () => {
  const error = {
    field: "/criteria/0/points",
    message: "/criteria/0/points: expected a number from 0E0 to 1E3, found -5",
  };
  assert.equal(plainMessage(error), "expected a number from 0 to 1000, found -5");
  assert.equal(placedMessage(error), "Criteria, 1, points: expected a number from 0 to 1000, found -5");
  assert.equal(
    placedMessage(error, "Mesial wall, points"),
    "Mesial wall, points: expected a number from 0 to 1000, found -5",
  );
  assert.equal(
    plainMessage({ field: "x", message: "from -1E9 to 2.5E-1, a code 5E0Z" }),
    "from -1000000000 to 0.25, a code 5E0Z",
  );
  assert.equal(
    placedMessage({ field: "title", message: "expected 1 to 200 bytes, found none" }),
    "Title: expected 1 to 200 bytes, found none",
  );
  assert.equal(placedMessage({ field: "max_stiffness_mn_per_mm", message: "too high" }), "Max stiffness: too high");
  assert.equal(placedMessage({ field: "no_such_thing", message: "unknown" }), "no_such_thing: unknown");
  assert.equal(placedMessage({ field: "", message: "Too large." }), "Too large.");
});
