// Types of the words, then of the HTTP API, from schemas/api/openapi.yaml into build/api.d.ts.
// Nothing is written when neither it nor this script changed, so that a build stays fast.
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createHash } from "node:crypto";
import { fileURLToPath } from "node:url";
import { generateWords } from "./words.mjs";

const source = new URL("../../schemas/api/openapi.yaml", import.meta.url);
const target = new URL("../build/api.d.ts", import.meta.url);

export async function generate() {
  generateWords();
  if (!existsSync(source)) {
    throw new Error(
      `expected the API contract at ${fileURLToPath(source)}, found nothing: check out the whole repository`,
    );
  }
  const made = createHash("sha256")
    .update(readFileSync(source))
    .update(readFileSync(new URL(import.meta.url)));
  const stamp = `// schema ${made.digest("hex")}\n`;
  if (existsSync(target) && readFileSync(target, "utf8").startsWith(stamp)) return;
  const { default: openapiTS, astToString } = await import("openapi-typescript");
  const ast = await openapiTS(source, {
    arrayLength: true,
    immutable: true,
    rootTypes: true,
    rootTypesNoSchemaPrefix: true,
    rootTypesKeepCasing: true,
  });
  mkdirSync(new URL(".", target), { recursive: true });
  writeFileSync(target, stamp + astToString(ast));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await generate();
