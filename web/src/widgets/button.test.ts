import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";

// What a button waits for only while the page works, which it shows: a reason is not needed.
const kWorking = /^((\w+\.)?busy|state === "busy"|busy === true)$/;

test("a button that is grey for more than a moment is a Button, which says why", () => {
  const files = readdirSync("src", { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".tsx"));
  const grey = files.flatMap((name) =>
    [...readFileSync(join("src", name), "utf8").matchAll(/\sdisabled=\{([^}]*)\}/g)].map((match) => ({
      name,
      when: match[1] ?? "",
    })),
  );
  assert.ok(grey.length > 10, `${grey.length} found`);
  assert.deepEqual(
    grey.filter(({ when }) => !kWorking.test(when)),
    [],
  );
});
