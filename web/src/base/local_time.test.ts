import assert from "node:assert/strict";
import { test } from "node:test";
import { fileName } from "./download";
import { fromLocalInput, relativeTime, toLocalInput } from "./local_time";

test("a time survives the input field to the minute", () => {
  const unixMs = new Date(2026, 2, 9, 8, 5).getTime();
  assert.equal(toLocalInput(unixMs), "2026-03-09T08:05");
  assert.equal(fromLocalInput(toLocalInput(unixMs)), unixMs);
});

test("no time is an empty field, and what is no time is none", () => {
  assert.equal(toLocalInput(0), "");
  for (const text of ["", "tomorrow", "2026-13-40T00:00", "2026-03-09"])
    assert.equal(fromLocalInput(text), undefined, text);
});

test("how long ago is said in the largest unit that fits", () => {
  const now = Date.UTC(2026, 2, 9);
  assert.match(relativeTime(now - 2 * 86_400_000, now), /2 days ago/);
  assert.match(relativeTime(now + 3 * 3_600_000, now), /in 3 hours/);
  assert.match(relativeTime(now - 90_000, now), /1 minute ago/);
});

test("a file's name has only what every file system takes", () => {
  assert.equal(fileName("Préclinic: 1/2", "..\\x.csv"), "Preclinic_1_2_x.csv");
});
