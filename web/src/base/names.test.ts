import assert from "node:assert/strict";
import test from "node:test";
import { namesIn } from "./names";

const person = (login: string, display_name: string) => ({ login, display_name });

test("two people of one name are told apart by their logins, one person who stands twice is not", () => {
  const people = [
    person("kim1", "Anna Kim"),
    person("kim2", "Anna Kim"),
    person("li", "Li Wei"),
    person("li", "Li Wei"),
  ];
  assert.deepEqual(people.map(namesIn(people)), ["Anna Kim (kim1)", "Anna Kim (kim2)", "Li Wei", "Li Wei"]);
});
