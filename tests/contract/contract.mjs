// schemas/api/openapi.yaml as data: its operations, who may call each, and what is wrong with an answer.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(new URL("../../web/package.json", import.meta.url));
const { default: Ajv } = require("ajv/dist/2020");
const yaml = require("js-yaml");
const kSchemas = new URL("../../schemas/", import.meta.url);

export const golden = (name) => JSON.parse(readFileSync(new URL(`golden/${name}.json`, kSchemas), "utf8"));

const kAlternatives = ["oneOf", "anyOf"];
const kParts = ["allOf", ...kAlternatives];
const kSaidOnly = ["description", "examples", "default"];
const kFormats = { uuid: /^[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$/ };

export class Contract {
  #ajv = new Ajv({ strict: false, allErrors: true, formats: kFormats });
  #validators = new Map();

  constructor(text = readFileSync(new URL("api/openapi.yaml", kSchemas), "utf8")) {
    this.document = yaml.load(text);
    const { schemas } = this.document.components;
    const named = Object.entries(schemas).flatMap(([name, schema]) => [
      [`closed.${name}`, this.#rewritten(schema, true)],
      [`open.${name}`, this.#rewritten(schema, false)],
    ]);
    this.#ajv.addSchema({ $id: "contract", $defs: Object.fromEntries(named) });
    this.operations = Object.entries(this.document.paths).flatMap(([path, methods]) =>
      Object.entries(methods).map(([method, said]) => this.#operation(method.toUpperCase(), path, said)),
    );
  }

  #at(ref) {
    return ref
      .slice(2)
      .split("/")
      .reduce((at, part) => at[part], this.document);
  }
  resolved(node) {
    if (node?.$ref === undefined) return node;
    const { $ref, ...beside } = node;
    return { ...this.resolved(this.#at($ref)), ...beside };
  }

  // A schema as a validator wants it. `closed`: an object has no members but those that are named. The parts of an allOf
  // stay open, since each knows some of the members only.
  #rewritten(schema, closed) {
    if (schema === null || typeof schema !== "object") return schema;
    const out = {};
    const merged = schema.properties !== undefined || schema.allOf !== undefined;
    for (const [keyword, value] of Object.entries(schema)) {
      if (kSaidOnly.includes(keyword)) continue;
      if (keyword === "$ref") out.$ref = `contract#/$defs/${closed ? "closed" : "open"}.${value.split("/").at(-1)}`;
      else if (keyword === "properties")
        out.properties = Object.fromEntries(Object.entries(value).map(([k, v]) => [k, this.#rewritten(v, true)]));
      else if (["items", "additionalProperties", "propertyNames"].includes(keyword))
        out[keyword] = this.#rewritten(value, true);
      else if (keyword === "allOf") out.allOf = value.map((part) => this.#rewritten(part, false));
      else if (kAlternatives.includes(keyword))
        out[keyword] = value.map((part) => this.#rewritten(part, closed && !merged));
      else out[keyword] = value;
    }
    if (closed && merged && schema.additionalProperties === undefined) out.unevaluatedProperties = false;
    return out;
  }

  // What is wrong with a value, one line each.
  problemsOf(schema, value) {
    if (!this.#validators.has(schema)) this.#validators.set(schema, this.#ajv.compile(this.#rewritten(schema, true)));
    const validate = this.#validators.get(schema);
    if (validate(value)) return [];
    return validate.errors.map(({ instancePath, message, params }) => {
      const place = instancePath.replace(/\/\d+(?=\/|$)/g, "[]") || "the body";
      const { unevaluatedProperty, allowedValues } = params;
      if (unevaluatedProperty !== undefined)
        return `${place} has a member ${unevaluatedProperty} that is not described`;
      if (allowedValues === undefined) return `${place} ${message}`;
      const found = instancePath
        .split("/")
        .slice(1)
        .reduce((at, part) => at[part], value);
      return `${place} has ${JSON.stringify(found)}, which is none of its values`;
    });
  }
  fits(schema, value) {
    return this.problemsOf(schema, value).length === 0;
  }

  // The members of an object's schema, with those of its parts, and which of them are required.
  shapeOf(schema) {
    const own = this.resolved(schema);
    const parts = (own.allOf ?? []).map((part) => this.shapeOf(part));
    const { properties, required, ...more } = own;
    return {
      ...Object.assign({}, ...parts, more),
      properties: Object.assign({}, ...parts.map((part) => part.properties), properties),
      required: [...parts.flatMap((part) => part.required), ...(required ?? [])],
    };
  }

  // Calls `each(owner, name)` for every member of a value that a schema describes. `owner` is the object of the schema
  // that names it.
  members(schema, value, each) {
    if (value === null || typeof value !== "object") return;
    if (schema.$ref !== undefined) this.members(this.#at(schema.$ref), value, each);
    for (const [name, of] of Object.entries(schema.properties ?? {})) {
      if (value[name] === undefined) continue;
      each(schema.properties, name);
      this.members(of, value[name], each);
    }
    if (Array.isArray(value) && schema.items !== undefined)
      for (const item of value) this.members(schema.items, item, each);
    if (typeof schema.additionalProperties === "object")
      for (const item of Object.values(value)) this.members(schema.additionalProperties, item, each);
    for (const part of kParts.flatMap((keyword) => schema[keyword] ?? [])) this.members(part, value, each);
  }

  // Every member that an answer can have: its owner, its name, and where it is described, "Attempt.person.id". Calls
  // `within(owner, name)` whether to look into one.
  answered(within) {
    const out = [];
    const open = [];
    const known = new Set();
    const walk = (schema, place) => {
      if (schema.$ref !== undefined && !known.has(schema.$ref)) {
        known.add(schema.$ref);
        open.push([this.#at(schema.$ref), schema.$ref.split("/").at(-1)]);
      }
      for (const [name, of] of Object.entries(schema.properties ?? {})) {
        out.push({ owner: schema.properties, name, place: `${place}.${name}` });
        if (within(schema.properties, name)) walk(of, `${place}.${name}`);
      }
      for (const part of [
        schema.items,
        schema.additionalProperties,
        ...kParts.flatMap((keyword) => schema[keyword] ?? []),
      ])
        if (typeof part === "object") walk(part, place);
    };
    for (const { id, responses } of this.operations)
      for (const { content = {} } of Object.values(responses))
        for (const { schema } of Object.values(content)) if (schema !== undefined) open.push([schema, id]);
    for (let next = open.shift(); next !== undefined; next = open.shift()) walk(...next);
    return out;
  }

  #operation(method, path, said) {
    const parameters = (said.parameters ?? []).map((parameter) => this.resolved(parameter));
    const header = (name) => parameters.find((of) => of.in === "header" && of.name === name);
    const responses = Object.fromEntries(
      Object.entries(said.responses).map(([status, response]) => [status, this.resolved(response)]),
    );
    const [type, content] = Object.entries(said.requestBody?.content ?? {})[0] ?? [];
    return {
      id: said.operationId,
      method,
      path,
      place: `${method} ${path}`,
      said,
      open: said.security?.length === 0,
      may: said["x-may"] ?? {},
      query: parameters.filter((of) => of.in === "query"),
      inPath: parameters.find((of) => of.in === "path"),
      guarded: header("X-Enamel-Csrf") !== undefined,
      ifMatch: header("If-Match")?.required === true,
      body: type && { type, schema: content.schema, required: said.requestBody.required === true },
      responses,
    };
  }

  // The response that the contract has for a status; undefined: none. What every operation can answer is not listed with
  // each: it follows from what the operation takes.
  responseOf(operation, status) {
    const { responses, method, open, inPath, body, query, ifMatch } = operation;
    if (responses[status] !== undefined) return responses[status];
    if (responses.default === undefined) return undefined;
    const implied = {
      400: inPath || body || query.length > 0,
      401: !open,
      403: !open || method !== "GET",
      404: inPath,
      412: ifMatch,
      413: body,
      415: body,
      428: ifMatch,
      503: true,
    };
    return implied[status] ? responses.default : undefined;
  }
}
