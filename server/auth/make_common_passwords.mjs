// Makes common_passwords.txt anew. Run by hand when the list is to be another; the build reads the file only:
//   npm pack @zxcvbn-ts/language-common@4.1.3 && tar xzf zxcvbn-ts-language-common-4.1.3.tgz
//   node server/auth/make_common_passwords.mjs package > server/auth/common_passwords.txt
import { readFileSync } from "node:fs";
import { join } from "node:path";

const folder = process.argv[2];
const { name, version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
const words = JSON.parse(readFileSync(join(folder, "src", "passwords.json"), "utf8"));
// Shorter ones say nothing: each character of a password is counted as 10 guesses anyway.
const lines = new Set(words.map((word) => word.toLowerCase()).filter((word) => /^[\x21-\x7e]{3,}$/.test(word)));
const terms = readFileSync(join(folder, "LICENSE.txt"), "utf8").trim().split("\n");
const head = [
  `Leaked passwords, the commonest first, of the npm package ${name} ${version} (${license}).`,
  "Made by make_common_passwords.mjs; lines that begin with # and a space are not of the list.",
  ...terms.filter((line) => line !== ""),
];
process.stdout.write([...head.map((line) => `# ${line}`), ...lines].join("\n") + "\n");
