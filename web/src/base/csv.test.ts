import assert from "node:assert/strict";
import { test } from "node:test";
import { csvText } from "./csv";

const body = (text: string) => text.replace(/^\uFEFF/, "");

test("cells with commas, quotes and line ends are quoted, others are not", () => {
  assert.equal(
    body(
      csvText(
        ["a", "b"],
        [
          ["x", 'y, "z"'],
          ["line\r\nend", null],
        ],
      ),
    ),
    'a,b\r\nx,"y, ""z"""\r\n"line\r\nend",\r\n',
  );
});

test("text that a spreadsheet takes for a formula is not one, also behind a tab or in full width", () => {
  for (const start of ["=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠"]) {
    const cell = body(csvText([], [[`${start}HYPERLINK(0)`]]))
      .split("\r\n")
      .slice(1)
      .join("\r\n");
    assert.match(cell, /^"?'/, JSON.stringify(start));
  }
});

test("numbers stay numbers, also negative ones; what is none is empty", () => {
  assert.equal(body(csvText(["n"], [[-1.5], [Number.NaN], [0]])), "n\r\n-1.5\r\n\r\n0\r\n");
});

test("the text begins with a byte order mark, once", () => {
  assert.equal([...csvText(["ä"], [["ö"]])].filter((c) => c === "\uFEFF").length, 1);
  assert.ok(csvText(["ä"], []).startsWith("\uFEFF"));
});
