// schemas/api/openapi.yaml as data: requests, what they may carry, and the shape of each answer.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(new URL("../../web/package.json", import.meta.url));
const { default: Ajv } = require("ajv/dist/2020");
const schemas = new URL("../../schemas/", import.meta.url);
const contract = require("js-yaml").load(readFileSync(new URL("api/openapi.yaml", schemas), "utf8"));
const ajv = new Ajv({
  strict: false,
  validateSchema: false,
  formats: { uuid: /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/ },
});

const kPrefix = "/api/v1";
const kNoId = "00000000-0000-7000-8000-000000000000";

// Of schemas/golden.
export const golden = (name) => JSON.parse(readFileSync(new URL(`golden/${name}.json`, schemas), "utf8"));
// Of a document that is not part of the API's contract: "rubric" is schemas/rubric.schema.json.
export const documentSchema = (name) => JSON.parse(readFileSync(new URL(`${name}.schema.json`, schemas), "utf8"));

function resolved(node) {
  if (node?.$ref === undefined) return node;
  return resolved(
    node.$ref
      .slice(2)
      .split("/")
      .reduce((at, part) => at[part], contract),
  );
}

function operationOf(method, path, { parameters = [], requestBody, responses, security }) {
  const success = Object.keys(responses).filter((status) => status.startsWith("2"));
  const params = parameters.map(resolved);
  return {
    method,
    path,
    route: `${method} ${path}`,
    segments: path.split("/").slice(1),
    open: security?.length === 0,
    // A POST that has made something, rather than only looked; all of it, rather than a part.
    status: Number(method === "POST" ? success.at(-1) : success[0]),
    headers: params.filter(({ in: place }) => place === "header"),
    query: params.filter(({ in: place }) => place === "query"),
    body: requestBody?.content["application/json"]?.schema,
    needsBody: requestBody?.required === true,
    response: (status) => resolved(responses[status] ?? responses.default),
    known: (status) => responses[status] !== undefined || status >= 400,
  };
}

export const operations = Object.entries(contract.paths)
  .filter(([path]) => path.startsWith(kPrefix))
  .flatMap(([path, methods]) =>
    Object.entries(methods).map(([method, operation]) =>
      operationOf(method.toUpperCase(), path.slice(kPrefix.length), operation),
    ),
  );

// Finds the operation of a request, and the id or name in its path.
export function operationFor(method, path) {
  const parts = path.split("/").slice(1).map(decodeURIComponent);
  const fits = ({ segments }) =>
    segments.length === parts.length && segments.every((segment, i) => segment.startsWith("{") || segment === parts[i]);
  const found = operations.filter((operation) => operation.method === method && fits(operation));
  const operation = found.find(({ segments }) => !segments.some((segment) => segment.startsWith("{"))) ?? found[0];
  return operation && { operation, id: parts[operation.segments.findIndex((segment) => segment.startsWith("{"))] };
}

const validators = new WeakMap();

// What is wrong with a value, as the server would name it; undefined where it keeps to the schema.
export function problemOf(schema, value) {
  if (!validators.has(schema)) validators.set(schema, ajv.compile({ ...schema, components: contract.components }));
  const validate = validators.get(schema);
  if (validate(value)) return undefined;
  const { instancePath, params, message } = validate.errors[0];
  const place = [instancePath, params.missingProperty ?? params.additionalProperty].filter((part) => part).join("/");
  const field = place
    .replace(/^\//, "")
    .replace(/\/(\d+)/g, "[$1]")
    .replaceAll("/", ".");
  return { field, message: `${field}: expected what ${message.replace(/^must /, "should ")}` };
}

// Merges a schema with its parts. Of several alternatives the first that is not null counts.
function shapeOf(schema) {
  const own = resolved(schema);
  const parts = [...(own.allOf ?? []), ...(own.oneOf ?? []).filter(({ type }) => type !== "null").slice(0, 1)].map(
    shapeOf,
  );
  return {
    ...Object.assign({}, ...parts),
    ...own,
    properties: Object.assign({}, ...parts.map(({ properties }) => properties), own.properties),
    required: [...parts.flatMap(({ required = [] }) => required), ...(own.required ?? [])],
  };
}

const mayBeNull = ({ type, oneOf = [] }) =>
  type === "null" || (Array.isArray(type) && type.includes("null")) || oneOf.some((each) => mayBeNull(resolved(each)));

// The least value that keeps to a schema.
export function sampleOf(schema) {
  const shape = shapeOf(schema);
  if (shape.default !== undefined) return shape.default;
  if (mayBeNull(shape)) return null;
  if (shape.enum !== undefined) return shape.enum[0];
  switch (shape.type) {
    case "object":
      return fitted(shape, {});
    case "array":
      return Array.from({ length: shape.minItems ?? 0 }, () => sampleOf(shape.items));
    case "string":
      return shape.format === "uuid" ? kNoId : "x".repeat(shape.minLength ?? 0);
    case "boolean":
      return false;
    default:
      return shape.minimum ?? 0;
  }
}

// Keeps the members that the schema knows, and adds samples for required members that are missing.
export function fitted(schema, value) {
  if (value === undefined) return sampleOf(schema);
  const shape = shapeOf(schema);
  if (value === null || typeof value !== "object") return value;
  if (Array.isArray(value)) return shape.items === undefined ? value : value.map((item) => fitted(shape.items, item));
  const names = Object.keys(shape.properties);
  if (names.length === 0) return value;
  return Object.fromEntries(
    names
      .filter((name) => value[name] !== undefined || shape.required.includes(name))
      .map((name) => [name, fitted(shape.properties[name], value[name])]),
  );
}

// An answer that is more than the value of a plain success. `tag`: the ETag, where it is not the
// thing's revision.
export class Reply {
  constructor(body, { status, headers = {}, tag, stream } = {}) {
    Object.assign(this, { body, status, headers, tag, stream });
  }
}
export const refused = (status, code, message, field = "", more = {}) =>
  new Reply({ error: { code, message, field }, ...more }, { status });
export const invalid = (field, message, more) => refused(400, "invalid_input", message, field, more);
export const conflict = (message, field) => refused(409, "conflict", message, field);
export const forbidden = (message, field) => refused(403, "forbidden", message, field);
