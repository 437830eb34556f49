// Guides and READMEs do not promise what is not there: guides.mjs BIN. Every link leads to a file, and to a heading in it. Every
// enamel-… command that is written in them has these subcommands and options, as the program's own --help lists them. What the
// guides set in italics is shown by the page or the window. Translations agree with their originals (translations.mjs).
import { execFileSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import { dirname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { languageOf, shownTexts, translatedGuides, wrongInTranslation } from './translations.mjs';
import { links, withoutBlocks } from './links.mjs';

const bin = process.argv[2];
const root = normalize(join(dirname(fileURLToPath(import.meta.url)), '../..'));
const translated = translatedGuides(root);
const guides = readdirSync(join(root, 'docs')).filter((name) => name.endsWith('.md')).map((name) => `docs/${name}`).concat(translated);
const files = [...guides, 'README.md', 'CHANGELOG.md', 'CONTRIBUTING.md', 'SECURITY.md', 'server/README.md', 'station/README.md', 'station/lab/README.md'];
let failed = 0;
const wrong = (file, text) => {
  console.error(`FAILED: ${file}: ${text}`);
  failed = 1;
};

const { slug, brokenLinks } = links(root);

const helps = new Map();
function helpOf(words) {
  const key = words.join(' ');
  if (!helps.has(key)) {
    let text = '';
    try {
      text = execFileSync(join(bin, words[0]), [...words.slice(1), '--help'], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'], timeout: 20000 });
    } catch {
      // Options and subcommands stay empty, so that whatever was asked for is missing.
    }
    const list = text.split(/^Subcommands:$/m)[1]?.split(/\n\n/)[0] ?? '';
    helps.set(key, {
      subcommands: new Set([...list.matchAll(/^ {2}([a-z-]+)/gm)].map((m) => m[1])),
      options: new Set([...text.matchAll(/--[a-z0-9-]+/g)].map((m) => m[0])),
    });
  }
  return helps.get(key);
}
const programs = new Set(['enamel-server', 'enamel-station', 'enamel-lab']);
let commands = 0;
function checkCommand(file, line) {
  const words = line.replace(/\s#.*$/, '').replace(/[[\]"]/g, ' ').split(/\s+/).filter(Boolean);
  const start = words.findIndex((word, i) => programs.has(word) && words[i - 1] !== '-u');
  if (start < 0 || words[0] === 'systemctl') return;
  const rest = words.slice(start + 1);
  const end = rest.findIndex((word) => /^[|&;]/.test(word));
  const own = end < 0 ? rest : rest.slice(0, end);
  ++commands;
  let at = [[words[start]]];
  while (own.length > 0 && /^[a-z][a-z|-]*$/.test(own[0])) {
    const known = helpOf(at[0]).subcommands;
    const named = own[0].split('|');
    if (known.size === 0) break;
    for (const name of named) {
      if (!known.has(name)) return wrong(file, `"${line.trim()}": ${at[0].join(' ')} has no command ${name}`);
    }
    at = named.map((name) => [...at[0], name]);
    own.shift();
  }
  const options = own.flatMap((word) => [...word.matchAll(/(?<![\w-])--[a-z][a-z0-9-]*/g)].map((m) => m[0]));
  for (const option of options) {
    if (!at.some((command) => helpOf(command).options.has(option))) {
      wrong(file, `"${line.trim()}": ${at.map((command) => command.join(' ')).join(', ')} has no option ${option}`);
    }
  }
}

// What people see, up to where a figure or a name is filled in; "Delete…" is also found as "Delete".
const shown = shownTexts(root);
function checkWords(file, text) {
  for (const [, phrase] of text.replace(/^ *\* /gm, '').matchAll(/(?<![*\w])\*(?![ *])([^*]+?)(?<! )\*(?![*\w])/g)) {
    const words = phrase.replace(/\s+/g, ' ');
    if (!shown[languageOf(file)].some((message) => message.startsWith(words))) wrong(file, `neither page nor window shows "${words}"`);
  }
}

for (const file of translated) {
  for (const text of wrongInTranslation(root, file)) wrong(file, text);
}
for (const file of files) {
  const text = readFileSync(join(root, file), 'utf8');
  for (const broken of brokenLinks(file)) wrong(file, broken);
  for (const [, block] of text.matchAll(/^ *```\w*\n([\s\S]*?)^ *```/gm)) {
    for (const line of block.replace(/\\\n/g, ' ').split('\n')) checkCommand(file, line);
  }
  if (/^docs\/(\w\w\/)?(for_|at_|first_)/.test(file)) checkWords(file, withoutBlocks(text));
  for (const [, span] of withoutBlocks(text).matchAll(/`([^`]*enamel-(?:server|station|lab) [^`]*)`/g)) {
    checkCommand(file, span.replace(/\n/g, ' '));
  }
}
// A text of more than 100 lines leads to each of its parts.
// docs/paper.md is made by enamel-lab.
for (const file of files.filter((name) => /^(docs|server|station)\//.test(name) && name !== 'docs/paper.md')) {
  const text = withoutBlocks(readFileSync(join(root, file), 'utf8'));
  const heads = [...text.matchAll(/^## +(.*)$/gm)].map((m) => m[1]);
  if (text.split('\n').length <= 100 || heads.length < 3) continue;
  const linked = new Set([...text.matchAll(/\]\(#([^)]+)\)/g)].map((m) => m[1]));
  for (const head of heads) if (!linked.has(slug(head))) wrong(file, `no link leads to its part "${head}"`);
}
for (const file of guides) {
  if (file !== 'docs/README.md' && !readFileSync(join(root, 'docs/README.md'), 'utf8').includes(`(${file.slice(5)})`)) {
    wrong('docs/README.md', `does not lead to ${file}`);
  }
}
// A release has its section; until then one collects what comes.
const changelog = readFileSync(join(root, 'CHANGELOG.md'), 'utf8');
const version = readFileSync(join(root, 'VERSION'), 'utf8').trim();
const sections = [...changelog.matchAll(/^## (.*)$/gm)].map((m) => m[1]);
if (!/^(Unreleased \([0-9.]+\)|[0-9.]+ - \d{4}-\d\d-\d\d)$/.test(sections[0] ?? '')) {
  wrong('CHANGELOG.md', `begins with "${sections[0]}", and not with "Unreleased (VERSION)" or "VERSION - DATE"`);
}
if (!sections[0]?.startsWith(`Unreleased (${version})`) && !sections[0]?.startsWith(`${version} - `)) {
  wrong('CHANGELOG.md', `begins with "${sections[0]}", and VERSION says ${version}`);
}
if (commands < 50) wrong('guides.mjs', `found only ${commands} commands`);
console.log(`${files.length} texts, ${commands} commands, ${helps.size} helps read`);
process.exit(failed);
