import assert from "node:assert/strict";
import { test } from "node:test";
import { placeText } from "./place_text";
import { placedMessage, plainMessage } from "./placed";

test("a place is named once, in words where there are some, and bounds are plain numbers", () => {
  const error = {
    field: "/criteria/0/points",
    message: "/criteria/0/points: expected a number from 0E0 to 1E3, found -5",
  };
  assert.equal(plainMessage(error), "expected a number from 0 to 1000, found -5");
  assert.equal(placedMessage(error), "/criteria/0/points: expected a number from 0 to 1000, found -5");
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
    "title: expected 1 to 200 bytes, found none",
  );
  assert.equal(placedMessage({ field: "", message: "Too large." }), "Too large.");
});

test("a place in a form is told in words", () => {
  assert.equal(placeText("/criteria/0/points"), "Criteria, 1, points");
  assert.equal(placeText("max_stiffness_mn_per_mm"), "Max stiffness");
  assert.equal(placeText("no_such_thing"), "no_such_thing");
});
