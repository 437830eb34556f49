import assert from "node:assert/strict";
import { test } from "node:test";
import { withLaterEdits } from "./use_edit";

test("an edit made while a save is under way outlives the server's answer", () => {
  const sent = { exam: false, sign_off: false, title: "Crown" };
  const answered = { exam: false, sign_off: false, title: "Crown" };
  assert.deepEqual(withLaterEdits(answered, sent, { ...sent, exam: true }), { ...answered, exam: true });
});

test("what the server settled otherwise is taken over where nobody edited since", () => {
  const sent = { name: " Ada ", pin: "1" };
  assert.deepEqual(withLaterEdits({ name: "Ada", pin: "" }, sent, { ...sent }), { name: "Ada", pin: "" });
});
