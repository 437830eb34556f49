import assert from "node:assert/strict";
import { test } from "node:test";
import { problemOf } from "./password_form";

test("a new password is long enough, another one, and typed twice alike", () => {
  assert.equal(problemOf("old one is here", "short", "short")?.field, "new");
  assert.match(problemOf("", "short", "short")!.text, /This password has 5/);
  assert.equal(problemOf("the very same words", "the very same words", "the very same words")?.field, "new");
  assert.equal(problemOf("old one is here", "four unrelated words here", "four unrelated word here")?.field, "again");
  assert.equal(problemOf("old one is here", "four unrelated words here", "four unrelated words here"), undefined);
});

test("length counts characters as people see them, not code units", () => {
  assert.match(problemOf("", "🦷🦷🦷🦷🦷🦷", "")!.text, /This password has 6/);
});
