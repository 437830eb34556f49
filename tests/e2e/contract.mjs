// The mock server answers only what schemas/api/openapi.yaml has, so that no flow passes on an
// interface that does not exist.
import { existsSync, readFileSync } from "node:fs";

const kContract = new URL("../../schemas/api/openapi.yaml", import.meta.url);
const kPrefix = "/api/v1";

// "GET /people/{id}" for each operation; the file is written with two spaces per level.
export function contractRoutes(text = readFileSync(kContract, "utf8")) {
  const routes = new Set();
  let path;
  for (const line of text.split("\n")) {
    const found = /^ {2}(\/\S*):/.exec(line)?.[1];
    if (found !== undefined) path = found.startsWith(kPrefix) ? found.slice(kPrefix.length) : undefined;
    else if (/^\S/.test(line)) path = undefined;
    const method = path === undefined ? undefined : /^ {4}(get|post|put|patch|delete):/.exec(line)?.[1];
    if (method !== undefined) routes.add(`${method.toUpperCase()} ${path}`);
  }
  return routes;
}

// Routes of the mock that the contract does not have.
export function inventedRoutes(mockRoutes) {
  if (!existsSync(kContract)) return [];
  const known = contractRoutes();
  return Object.keys(mockRoutes).filter((route) => !known.has(route));
}
