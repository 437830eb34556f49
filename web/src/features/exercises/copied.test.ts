import assert from "node:assert/strict";
import { test } from "node:test";
import { copied, isName, nameFor } from "./copied";

test("a title makes a name that the server takes", () => {
  for (const [title, name] of [
    ["Class I, term 2", "class-i-term-2"],
    ["Füllung (groß)", "fullung-gross"],
    ["  –  ", ""],
    ["窝洞", ""],
  ] as const)
    assert.equal(nameFor(title), name);
  const long = nameFor("a b".repeat(60));
  assert.ok(long.length <= 64 && isName(long), long);
  assert.ok(!isName("") && !isName("Class I") && isName("class_i-2"));
});

test("a copy differs in name and title alone", () => {
  const document = { name: "one", title: "One", rubric: { criteria: [1] } };
  assert.deepEqual(copied(document, "two", "Two"), { name: "two", title: "Two", rubric: { criteria: [1] } });
  assert.equal(document.name, "one");
});
