// Holds schemas/api/openapi.yaml to OpenAPI 3.1, and to what OpenAPI does not ask for: lint_contract.mjs [FILE].
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { createConfig, lintFromString } from "@redocly/openapi-core";
import yaml from "js-yaml";

const kContract = fileURLToPath(new URL("../../schemas/api/openapi.yaml", import.meta.url));
// Of a flow mapping, a comma in a description that nobody quoted makes a member of its own: `struct` finds it.
const kRules = [
  "struct",
  "no-unresolved-refs",
  "no-unused-components",
  "no-identical-paths",
  "no-ambiguous-paths",
  "no-enum-type-mismatch",
  "no-required-schema-properties-undefined",
  "no-invalid-media-type-examples",
  "no-invalid-schema-examples",
  "no-invalid-parameter-examples",
  "operation-operationId",
  "operation-operationId-unique",
  "operation-parameters-unique",
  "operation-summary",
  "path-parameters-defined",
  "path-not-include-query",
  "security-defined",
];
const kErrors = "#/components/responses/Error";

async function againstOpenApi(text, name) {
  const config = await createConfig({ rules: Object.fromEntries(kRules.map((rule) => [rule, "error"])) });
  const found = await lintFromString({ source: text, absoluteRef: name, config });
  return found.map(({ ruleId, message, location }) => `${location[0]?.pointer ?? "#/"}: ${message} (${ruleId})`);
}

// What every operation says about refusals, and about the header that guards a change.
function ofOperation(place, { security, parameters = [], responses }, method) {
  const out = [];
  const open = security?.length === 0;
  if (!open && responses.default?.$ref !== kErrors)
    out.push(`${place}: expected the response "default" to be ${kErrors}: every operation can be refused`);
  const guarded = parameters.some(({ $ref }) => $ref === "#/components/parameters/Csrf");
  const changes = method !== "get";
  if (changes && !open && !guarded) out.push(`${place}: expected the parameter Csrf of a change`);
  if (!changes && guarded) out.push(`${place}: expected no parameter Csrf of what only reads`);
  return out;
}

// A list of numbers is looked through by their names. What names them is therefore enumerated, so that a page cannot look
// for another.
const kNames = ["name", "metric", "criterion", "code", "error", "unit", "what", "why"];
// Criteria of marks that people wrote, by the titles that they gave them.
const kFree = [
  "#/components/schemas/Marking/properties/results/properties/agreement",
  "#/components/schemas/StandardSetting/properties/angoff/properties/criteria",
];
const isNumber = ([name, { type }]) =>
  type === "number" || type?.includes?.("number") || (/^values?$/.test(name) && type !== "string");
function ofLists(place, schema, schemas) {
  if (schema === null || typeof schema !== "object") return [];
  const out = Object.entries(schema).flatMap(([name, of]) => ofLists(`${place}/${name}`, of, schemas));
  const { $ref, ...own } = schema.items ?? {};
  const { properties } = $ref === undefined ? own : schemas[$ref.split("/").at(-1)];
  if (
    kFree.includes(place) ||
    properties === undefined ||
    properties.id !== undefined ||
    !Object.entries(properties).some(isNumber)
  )
    return out;
  const open = kNames.filter((name) => properties[name]?.type === "string" && properties[name].enum === undefined);
  return [
    ...out,
    ...open.map((name) => `${place}: expected the values of "${name}" to be enumerated: it names numbers`),
  ];
}

// A member says what it is: itself, by what it refers to, by its values, or by its parts; else by its name, which then
// means the same everywhere (x-members).
const kSays = ["description", "$ref", "allOf", "oneOf", "enum", "properties", "items", "additionalProperties"];
function ofMembers(place, schema, known, used) {
  if (schema === null || typeof schema !== "object") return [];
  const out = Object.entries(schema).flatMap(([name, of]) => ofMembers(`${place}/${name}`, of, known, used));
  if (typeof schema.properties !== "object") return out;
  const bare = Object.entries(schema.properties)
    .filter(([, of]) => !kSays.some((keyword) => of?.[keyword] !== undefined) && of?.type !== "boolean")
    .map(([name]) => name);
  for (const name of bare) used.add(name);
  const unsaid = bare.filter((name) => known[name] === undefined);
  return [...out, ...unsaid.map((name) => `${place}/${name}: expected a description, or one of the name in x-members`)];
}

// What is wrong, one line each.
export async function problemsOf(text, name = kContract) {
  const contract = yaml.load(text);
  const operations = Object.entries(contract.paths).flatMap(([path, methods]) =>
    Object.entries(methods).flatMap(([method, operation]) =>
      ofOperation(`${method.toUpperCase()} ${path}`, operation, method),
    ),
  );
  const names = contract["x-members"] ?? {};
  const used = new Set();
  const members = ofMembers("#", { paths: contract.paths, components: contract.components }, names, used);
  const idle = Object.keys(names).filter((each) => !used.has(each));
  return [
    ...(await againstOpenApi(text, name)),
    ...operations,
    ...ofLists("#", contract, contract.components.schemas),
    ...members,
    ...idle.map((each) => `#/x-members/${each}: no member needs it`),
  ];
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const file = process.argv[2] ?? kContract;
  const problems = await problemsOf(readFileSync(file, "utf8"), file);
  for (const problem of problems) console.error(`${file}: ${problem}`);
  process.exit(problems.length > 0 ? 1 : 0);
}
