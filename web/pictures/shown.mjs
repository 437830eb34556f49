// shown.mjs RUBRIC.json SHOWN.json PICTURE...: writes into SHOWN.json, for each picture of a score, its hash and the rubric
// that it shows. tests/common/scene/readme_pictures_test.cpp compares this with the rubric of today.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { basename } from "node:path";

const sha256 = (path) => createHash("sha256").update(readFileSync(path)).digest("hex");
const [document, out, ...pictures] = process.argv.slice(2);
const { name, version } = JSON.parse(readFileSync(document, "utf8"));
const rubric = { name, version, sha256: sha256(document) };
const made = pictures.map((path) => ({ picture: basename(path), sha256: sha256(path), rubric }));
const others = JSON.parse(readFileSync(out, "utf8")).filter((kept) =>
  made.every(({ picture }) => picture !== kept.picture),
);
const all = [...others, ...made].sort((a, b) => (a.picture < b.picture ? -1 : 1));
writeFileSync(out, `${JSON.stringify(all, undefined, 2)}\n`);
