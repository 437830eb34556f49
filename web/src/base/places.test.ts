import assert from "node:assert/strict";
import { test } from "node:test";
import { Places } from "./places";

test("going back returns to the place, and so does going on again", () => {
  const places = new Places(0);
  places.seen(900);
  const attempt = places.opened();
  places.seen(0);
  places.seen(250);
  assert.equal(places.returned(0), 900);
  assert.equal(places.returned(attempt), 250);
});

test("an entry from before the page was loaded begins at its top", () => {
  const places = new Places(3);
  assert.equal(places.returned(1), 0);
  assert.equal(places.opened(), 4);
});
