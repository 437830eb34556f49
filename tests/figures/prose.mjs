// Figures that stand in prose and tables, outside the marks of figures.mjs: numbers with a unit. listed.txt names each, so that a
// new or a changed one fails until somebody has said where it comes from:
//
//   DATE  FILE  ORIGIN  NUMBERS OF ONE PARAGRAPH OR ROW
//
// DATE is the day on which they were written. ORIGIN is one of
//
//   limit PATH  the file of the program that keeps to it, or of the test that holds it
//   goal        what we aim at; the text says where we miss it
//   asked       what the reader is asked to have or to do
//   source      published, or a maker's; the text names who says so
//
// What a command measures has no place here: it stands between marks (figures.mjs).
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const kUnit =
  /(?<![\w.,−-])[−-]?\d[\d.,\u202f ]*(?:[ \u00a0]?(?:%|°)|[ \u00a0](?:[munµ]?s|seconds?|min|minutes?|h|hours?|days?|weeks?|years?|[munµ]?m|cm|inch(?:es)?|m?N(?:[·/ ](?:s\/)?m?m)?|k?g|[kM]?Hz|k?bit\/s|bytes?|[kMG]i?B|ticks?|points?|cores?|CPU))(?![\w/])/;
// Made as a whole by a command, and compared with what it prints.
const kMade = new Set(['docs/paper.md']);
const isOrigin = (origin, root) => ['goal', 'asked', 'source'].includes(origin) || (/^limit \S/.test(origin) && existsSync(join(root, origin.slice(6))));

const blank = (text) => text.replace(/[^\n]/g, ' ');
export function blocksOf(markdown) {
  const text = markdown
    .replace(/<!-- figures [^>]+ -->[\s\S]*?<!-- end -->/g, blank)
    .replace(/^ *```[\s\S]*?^ *```/gm, blank);
  const blocks = [];
  for (const part of text.split(/\n(?=\s*\n|\||\s*[*\d][*.]? |#)/)) {
    const says = part.replace(/`[^`]*`/g, ' ').replace(/\]\([^)]*\)/g, ']').replace(/\s+/g, ' ');
    const numbers = [...says.matchAll(/(?<![\w.])[−-]?\d[\d.]*/g)].map((m) => m[0].replace(/\.$/, '')).join(' ');
    if (kUnit.test(says)) blocks.push(numbers);
  }
  return blocks;
}

export function proseFiles(root) {
  const below = ['docs', 'station'].flatMap((folder) => readdirSync(join(root, folder), { recursive: true }).map((name) => join(folder, name)));
  return ['README.md', ...below.filter((name) => name.endsWith('.md')).sort(), 'tests/bench/README.md', 'tests/load/README.md'].filter((file) => !kMade.has(file));
}

// What is wrong, a sentence each. `write` lists what is new under today's date, and forgets what is gone.
export function checkProse(root, list, write) {
  const wrong = [];
  const rows = readFileSync(list, 'utf8').split('\n').filter(Boolean).map((line) => line.split('\t'));
  const listed = new Map();
  for (const row of rows) listed.set(`${row[1]}\t${row[3]}`, [...(listed.get(`${row[1]}\t${row[3]}`) ?? []), row]);
  const kept = [];
  for (const file of proseFiles(root)) {
    for (const figures of blocksOf(readFileSync(join(root, file), 'utf8'))) {
      const row = listed.get(`${file}\t${figures}`)?.shift() ?? [new Date().toISOString().slice(0, 10), file, '?', figures];
      if (!rows.includes(row) && !write) wrong.push(`${file} has "${figures}", which ${list} does not list: run tests/figures/figures.mjs with --write`);
      else if (!isOrigin(row[2], root)) wrong.push(`${list}: say where "${figures}" in ${file} comes from (prose.mjs), in place of "${row[2]}"`);
      kept.push(row);
    }
  }
  for (const [, left] of listed) for (const row of write ? [] : left) wrong.push(`${list} has "${row[3]}", which ${row[1]} does not show: run tests/figures/figures.mjs with --write`);
  if (write) writeFileSync(list, `${kept.map((row) => row.join('\t')).join('\n')}\n`);
  const count = {};
  for (const [, , origin] of kept) count[origin.split(' ')[0]] = (count[origin.split(' ')[0]] ?? 0) + 1;
  return { wrong, count };
}
