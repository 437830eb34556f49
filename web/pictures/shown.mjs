// shown.mjs RUBRIC.json PICTURE.png...: prints, for each picture of a score, its hash and the rubric
// that it shows. tests/common/scene/pictures_test.cpp compares this with the rubric of today.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { basename } from "node:path";

const sha256 = (path) => createHash("sha256").update(readFileSync(path)).digest("hex");
const [document, ...pictures] = process.argv.slice(2);
const { name, version } = JSON.parse(readFileSync(document, "utf8"));
const rubric = { name, version, sha256: sha256(document) };
const shown = pictures.map((path) => ({ picture: basename(path), sha256: sha256(path), rubric }));
console.log(JSON.stringify(shown, undefined, 2));
