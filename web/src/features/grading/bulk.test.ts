import assert from "node:assert/strict";
import { test } from "node:test";
import { fail, ok } from "../../base/result";
import { forEach, inTurn } from "./bulk";

test("failures are reported with their reason, and the rest is done", async () => {
  const refusal = { code: "conflict", status: 409, message: "is scored now", field: "" } as const;
  const outcome = await forEach(["a", "b", "c"], async (item) => (item === "b" ? fail(refusal) : ok(undefined)));
  assert.deepEqual(outcome, { done: ["a", "c"], failed: [{ item: "b", message: "is scored now" }] });
});

test("each is requested once, and never more at a time than allowed", async () => {
  let [open, most] = [0, 0];
  const asked: number[] = [];
  await inTurn(
    Array.from({ length: 20 }, (_, i) => i),
    3,
    async (item) => {
      asked.push(item);
      most = Math.max(most, ++open);
      await Promise.resolve();
      --open;
    },
  );
  assert.deepEqual(
    asked.sort((a, b) => a - b),
    Array.from({ length: 20 }, (_, i) => i),
  );
  assert.equal(most, 3);
});
