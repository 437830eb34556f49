// Guides and READMEs do not promise what is not there: guides.mjs BIN. Every link leads to a file, and to a heading in it. Every
// enamel-… command that is written in them has these subcommands and options, as the program's own --help lists them. What the
// guides set in italics is shown by the page or the window.
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { dirname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

const bin = process.argv[2];
const root = normalize(join(dirname(fileURLToPath(import.meta.url)), '../..'));
const guides = readdirSync(join(root, 'docs')).filter((name) => name.endsWith('.md')).map((name) => `docs/${name}`);
const files = [...guides, 'README.md', 'CHANGELOG.md', 'CONTRIBUTING.md', 'SECURITY.md', 'server/README.md', 'station/README.md', 'station/lab/README.md'];
let failed = 0;
const wrong = (file, text) => {
  console.error(`FAILED: ${file}: ${text}`);
  failed = 1;
};

// As GitHub makes a heading's anchor.
const slug = (heading) => heading.replace(/[`*]/g, '').trim().toLowerCase().replace(/[^\p{L}\p{N}\s_-]/gu, '').replace(/\s/g, '-');
const anchors = new Map();
function anchorsOf(path) {
  if (!anchors.has(path)) {
    const text = readFileSync(path, 'utf8').replace(/^ *```[\s\S]*?^ *```/gm, '');
    anchors.set(path, new Set([...text.matchAll(/^#+ +(.*)$/gm)].map((m) => slug(m[1]))));
  }
  return anchors.get(path);
}
function checkLinks(file, text) {
  for (const [, target] of text.matchAll(/\]\(([^)\s]+)\)/g)) {
    if (/^[a-z]+:/.test(target)) continue;
    const [path, anchor] = target.split('#');
    const full = path ? join(root, dirname(file), path) : join(root, file);
    if (!existsSync(full)) wrong(file, `a link to ${target}, which is not there`);
    else if (anchor && full.endsWith('.md') && !anchorsOf(full).has(anchor)) wrong(file, `${path || file} has no heading #${anchor}`);
  }
}

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
// The lab's older names, which the station still starts.
const lent = new Set(['qualify', 'fit-damping', 'explain', 'frame-bench']);
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
    if (words[start] === 'enamel-station' && lent.has(named[0])) return;
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
const shown = ['page', 'window', 'exercise'].flatMap((name) =>
  Object.values(JSON.parse(readFileSync(join(root, `schemas/words/en/${name}.json`), 'utf8')).messages),
);
function checkWords(file, text) {
  for (const [, phrase] of text.replace(/^ *\* /gm, '').matchAll(/(?<![*\w])\*(?![ *])([^*]+?)(?<! )\*(?![*\w])/g)) {
    const words = phrase.replace(/\s+/g, ' ');
    if (!shown.some((message) => message.startsWith(words))) wrong(file, `neither page nor window shows "${words}"`);
  }
}

for (const file of files) {
  const text = readFileSync(join(root, file), 'utf8');
  checkLinks(file, text.replace(/^ *```[\s\S]*?^ *```/gm, ''));
  for (const [, block] of text.matchAll(/^ *```\w*\n([\s\S]*?)^ *```/gm)) {
    for (const line of block.replace(/\\\n/g, ' ').split('\n')) checkCommand(file, line);
  }
  if (/^docs\/(for_|at_)/.test(file)) checkWords(file, text.replace(/^ *```[\s\S]*?^ *```/gm, ''));
  for (const [, span] of text.replace(/^ *```[\s\S]*?^ *```/gm, '').matchAll(/`([^`]*enamel-(?:server|station|lab) [^`]*)`/g)) {
    checkCommand(file, span.replace(/\n/g, ' '));
  }
}
// A text of more than 100 lines leads to each of its parts.
// docs/paper.md is made by enamel-lab.
for (const file of files.filter((name) => /^(docs|server|station)\//.test(name) && name !== 'docs/paper.md')) {
  const text = readFileSync(join(root, file), 'utf8').replace(/^ *```[\s\S]*?^ *```/gm, '');
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
const [, version] = readFileSync(join(root, 'CMakeLists.txt'), 'utf8').match(/^project\(enamel VERSION ([0-9.]+)/m);
const sections = [...changelog.matchAll(/^## (.*)$/gm)].map((m) => m[1]);
if (!/^(Unreleased \([0-9.]+\)|[0-9.]+ - \d{4}-\d\d-\d\d)$/.test(sections[0] ?? '')) {
  wrong('CHANGELOG.md', `begins with "${sections[0]}", and not with "Unreleased (VERSION)" or "VERSION - DATE"`);
}
if (!sections[0]?.startsWith('Unreleased') && !sections[0]?.startsWith(`${version} `)) {
  wrong('CHANGELOG.md', `does not begin with version ${version}, which CMakeLists.txt names`);
}
if (commands < 50) wrong('guides.mjs', `found only ${commands} commands`);
console.log(`${files.length} texts, ${commands} commands, ${helps.size} helps read`);
process.exit(failed);
