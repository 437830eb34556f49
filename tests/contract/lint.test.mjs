// Each fault that the lint of schemas/api/openapi.yaml is for, planted.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { problemsOf } from "../../web/scripts/lint_contract.mjs";

const text = readFileSync(new URL("../../schemas/api/openapi.yaml", import.meta.url), "utf8");

// The contract with one place changed.
function planted(from, to) {
  assert.ok(text.includes(from), `the contract still has ${JSON.stringify(from)}`);
  return text.replace(from, to);
}

test("the contract has no problem", async () => assert.deepEqual(await problemsOf(text), []));

const kFaults = {
  "a comma that nobody quoted": [
    "description: 'Of a draft, when it was last put'",
    "description: Of a draft, when it was last put",
  ],
  "a reference to nothing": ["$ref: '#/components/schemas/Health'", "$ref: '#/components/schemas/Heath'"],
  "a component that nobody uses": ["    Reason:\n", "    Unused: {type: string}\n    Reason:\n"],
  "a member that is required and not described": [
    "required: [code, values, units]",
    "required: [code, values, units, sign]",
  ],
  "an operation without its refusals": [
    "        '204': {description: Forgotten}\n        default: {$ref: '#/components/responses/Error'}\n",
    "        '204': {description: Forgotten}\n",
  ],
  "a change without its guard": [
    "        - {$ref: '#/components/parameters/Id'}\n        - {$ref: '#/components/parameters/Csrf'}\n",
    "        - {$ref: '#/components/parameters/Id'}\n",
  ],
  "names of numbers that may be any": ["{$ref: '#/components/schemas/ReasonCode'}", "{type: string}"],
  "a member without a word": [
    "        csrf: {type: string}",
    "        csrf: {type: string}\n        unsaid: {type: integer}",
  ],
  "a name twice": ["operationId: getAlive", "operationId: getReady"],
};
for (const [name, [from, to]] of Object.entries(kFaults))
  test(`${name} is found`, async () => assert.notDeepEqual(await problemsOf(planted(from, to)), []));
