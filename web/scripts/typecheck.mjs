// Types of the page, then of its tests, which alone may see Node's. Fails with tsc's own words.
import { spawnSync } from "node:child_process";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";
import { generate } from "./generate.mjs";

await generate();
const tsc = createRequire(import.meta.url).resolve("typescript/bin/tsc");
const cwd = fileURLToPath(new URL("..", import.meta.url));
for (const project of ["tsconfig.json", "tsconfig.test.json"]) {
  const { status } = spawnSync(process.execPath, [tsc, "-p", project], { cwd, stdio: "inherit" });
  if (status !== 0) process.exit(status ?? 1);
}
