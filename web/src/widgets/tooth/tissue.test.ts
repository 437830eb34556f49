import assert from "node:assert/strict";
import { test } from "node:test";
import { kTissueNames, workpiece } from "./tissue";

const numbers = (...names: (typeof kTissueNames)[number][]) => names.map((name) => kTissueNames.indexOf(name));

test("a block of gypsum is not called a tooth, and a tooth beside a neighbour is one", () => {
  assert.equal(workpiece(numbers("gypsum")), "block");
  assert.equal(workpiece(numbers("enamel", "dentin", "neighbour")), "tooth");
  assert.equal(workpiece(numbers("caries")), "tooth");
});
