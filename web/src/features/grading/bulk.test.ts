import assert from "node:assert/strict";
import { test } from "node:test";
import { fail, ok } from "../../base/result";
import { forEach } from "./bulk";

test("failures are reported with their reason, and the rest is done", async () => {
  const refusal = { code: "conflict", status: 409, message: "is scored now", field: "" } as const;
  const outcome = await forEach(["a", "b", "c"], async (item) => (item === "b" ? fail(refusal) : ok(undefined)));
  assert.deepEqual(outcome, { done: ["a", "c"], failed: [{ item: "b", message: "is scored now" }] });
});
