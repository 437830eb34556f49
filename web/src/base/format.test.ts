import assert from "node:assert/strict";
import { test } from "node:test";
import {
  sentence,
  formatBytes,
  formatDate,
  formatDateTime,
  formatDuration,
  formatLimit,
  formatMoment,
  formatNumber,
  formatQuantity,
  formatSigned,
  micrometresAsMm,
  kScoreStep,
  scoreForField,
} from "./format";
import { speak } from "./language";

test("angles have their sign without a blank", () => {
  assert.equal(formatQuantity(7.25, "deg"), "7.3°");
});

test("a deviation that rounds to zero carries no sign", () => {
  assert.equal(formatSigned(0.001), "0.00");
  assert.equal(formatSigned(-0.001), "0.00");
  assert.equal(formatSigned(0.3), "+0.30");
  assert.equal(formatSigned(-0.31), "−0.31");
});

test("a value that is not a number is shown as a dash and never as NaN", () => {
  assert.equal(formatNumber(Number.NaN), "–");
  assert.equal(formatQuantity(Number.POSITIVE_INFINITY, "mm"), "–");
  assert.equal(formatDuration(-1), "–");
});

test("a quantity has as many decimals as anybody acts on, and its unit", () => {
  assert.equal(formatQuantity(0.0421, "mm"), "0.04\u00a0mm");
  assert.equal(formatQuantity(0.275, "mm"), "0.28\u00a0mm");
  assert.equal(formatQuantity(-0.004, "mm"), "0.00\u00a0mm");
  assert.equal(formatQuantity(12.345, "mm3"), "12.35\u00a0mm³");
  assert.equal(formatQuantity(0.5, "mm3/s"), "0.50\u00a0mm³/s");
  assert.equal(formatQuantity(99.14, "%"), "99.1\u00a0%");
  assert.equal(formatQuantity(42180, "count"), "42\u202f180");
});

test("a limit is shown unrounded, in the form of the measured value", () => {
  assert.equal(formatLimit(0.025, "mm"), "0.025\u00a0mm");
  assert.equal(formatLimit(0.1, "mm"), "0.10\u00a0mm");
  assert.equal(formatLimit(97, "%"), "97.0\u00a0%");
  assert.equal(formatLimit(240, "s"), "4\u00a0min\u00a000\u00a0s");
});

test("a small torque is shown in millinewton metres, not as zero", () => {
  assert.equal(formatQuantity(0.00024, "N m").replaceAll("\u00a0", " "), "0.24 mN m");
  assert.equal(formatQuantity(0.5, "N m").replaceAll("\u00a0", " "), "0.5 N m");
});

test("times, sizes and lengths use the unit people expect", () => {
  assert.equal(formatDuration(42.4), "42.4\u00a0s");
  assert.equal(formatDuration(59.97), "1\u00a0min\u00a000\u00a0s");
  assert.equal(formatDuration(125), "2\u00a0min\u00a005\u00a0s");
  speak("zh");
  assert.deepEqual([formatDuration(95), formatDuration(4.25)], ["1分钟35秒", "4.3秒"]);
  speak("en");
  assert.equal(formatBytes(173_214), "173.2 kB");
  assert.equal(micrometresAsMm(600), "0.6\u00a0mm");
});

test("a score that fills a field lies on the field's steps", () => {
  assert.equal(scoreForField(71.42857142857143), 71.4);
  for (const score of [71.42857142857143, 0.05, 99.99, 33.333333333333336]) {
    const steps = scoreForField(score) / kScoreStep;
    assert.ok(Math.abs(steps - Math.round(steps)) < 1e-9, String(score));
  }
  assert.ok(Number.isNaN(scoreForField(Number.NaN)));
});

test("one quantity has one form: a deviation with or without sign, a time as a measurement or as a duration", () => {
  for (const mm of [0.275, 0.291, 0.26, 0.05, 1.234])
    assert.equal(`${formatSigned(mm)}\u00a0mm`, `+${formatQuantity(mm, "mm")}`);
  for (const seconds of [42.18, 127.4]) assert.equal(formatQuantity(seconds, "s"), formatDuration(seconds));
  assert.equal(formatQuantity(127.4, "s"), "2\u00a0min\u00a007\u00a0s");
});

test("a moment is shown in minutes, seconds and tenths", () => {
  assert.equal(formatMoment(127.4), "2:07.4");
  assert.equal(formatMoment(5), "0:05.0");
  assert.equal(formatMoment(59.96), "1:00.0");
  assert.equal(formatMoment(-1), "–");
});

test("the format of a date is made once in each language", () => {
  const real = Intl.DateTimeFormat;
  let made = 0;
  Intl.DateTimeFormat = class extends real {
    constructor(...given: ConstructorParameters<typeof real>) {
      super(...given);
      ++made;
    }
  } as typeof real;
  try {
    speak("de");
    const [german] = [formatDateTime(1e12), formatDateTime(2e12), formatDate(1e12), formatDate(2e12)];
    assert.equal(made, 2, "with and without the time of day");
    speak("en");
    assert.notEqual(formatDateTime(1e12), german);
  } finally {
    Intl.DateTimeFormat = real;
    speak("en");
  }
});

test("what the server says reads as a sentence", () => {
  assert.equal(sentence("only instructors can do this"), "Only instructors can do this.");
  assert.equal(sentence("Send If-Match."), "Send If-Match.");
  assert.equal(sentence("target.depth_um: expected 100 to 8000"), "target.depth_um: expected 100 to 8000");
  assert.equal(sentence("m"), "m");
});
