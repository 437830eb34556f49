// Figures that stand in prose and tables, outside the marks of figures.mjs: numbers with a unit. listed.txt names each, so that a
// new or a changed one fails until somebody has said where it comes from:
//
//   DATE  FILE  ORIGIN  NUMBERS OF ONE PARAGRAPH OR ROW
//
// DATE is the day on which they were written. ORIGIN is the command that had printed them; "limit": the program keeps to it, or the reader is asked to; or
// "source": published, or a maker's, and the text names who says so. In a table the command is the row's last one, "same" the one above.
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const kUnit =
  /(?<![\w.,−-])[−-]?\d[\d.,\u202f ]*(?:[ \u00a0]?(?:%|°)|[ \u00a0](?:[munµ]?s|seconds?|min|minutes?|h|hours?|days?|weeks?|years?|[munµ]?m|cm|inch(?:es)?|m?N(?:[·/ ](?:s\/)?m?m)?|k?g|[kM]?Hz|k?bit\/s|bytes?|[kMG]i?B|ticks?|points?|cores?|CPU))(?![\w/])/;
// Made as a whole by a command, and compared with what it prints.
const kMade = new Set(['docs/paper.md']);
const isCommand = (span) => /^(ENAMEL_\w+=\S+ )*(enamel-(lab|server|station|loadgen) [\w-]|node |\.\/(run|check)|tests\/|packaging\/|[a-z_]+_(test|bench)\b|stolen_chair)/.test(span);

const blank = (text) => text.replace(/[^\n]/g, ' ');
export function blocksOf(markdown) {
  const text = markdown
    .replace(/<!-- figures [^>]+ -->[\s\S]*?<!-- end -->/g, blank)
    .replace(/^ *```[\s\S]*?^ *```/gm, blank);
  const blocks = [];
  let above = '';
  let line = 1;
  for (const part of text.split(/\n(?=\s*\n|\||\s*[*\d][*.]? |#)/)) {
    const spans = [...part.matchAll(/`([^`]+)`/g)].map((m) => m[1].replace(/\s+/g, ' '));
    const own = spans.filter(isCommand).at(-1);
    const isRow = part.startsWith('|');
    if (own || !isRow) above = own ?? '';
    const says = part.replace(/`[^`]*`/g, ' ').replace(/\]\([^)]*\)/g, ']').replace(/\s+/g, ' ');
    const numbers = [...says.matchAll(/(?<![\w.])[−-]?\d[\d.]*/g)].map((m) => m[0].replace(/\.$/, '')).join(' ');
    if (kUnit.test(says)) blocks.push({ figures: numbers, command: isRow && /\bsame\b/.test(part) ? above : (own ?? ''), line, lines: part.split('\n').length, says });
    line += part.split('\n').length;
  }
  return blocks;
}

export function proseFiles(root) {
  const guides = readdirSync(join(root, 'docs')).filter((name) => name.endsWith('.md')).map((name) => `docs/${name}`);
  return ['README.md', ...guides, 'station/README.md', 'tests/bench/README.md'].filter((file) => !kMade.has(file));
}

// What is wrong, a sentence each. `write` lists what is new under today's date, and forgets what is gone.
export function checkProse(root, list, write) {
  const wrong = [];
  const rows = readFileSync(list, 'utf8').split('\n').filter(Boolean).map((line) => line.split('\t'));
  const listed = new Map();
  for (const row of rows) listed.set(`${row[1]}\t${row[3]}`, [...(listed.get(`${row[1]}\t${row[3]}`) ?? []), row]);
  const kept = [];
  for (const file of proseFiles(root)) {
    for (const { figures, command } of blocksOf(readFileSync(join(root, file), 'utf8'))) {
      const row = listed.get(`${file}\t${figures}`)?.shift() ?? [new Date().toISOString().slice(0, 10), file, command || '?', figures];
      if (!rows.includes(row) && !write) wrong.push(`${file} has "${figures}", which ${list} does not list: run tests/figures/figures.mjs with --write`);
      if (row[2] === '?' && (write || rows.includes(row))) wrong.push(`${list}: say where "${figures}" in ${file} comes from, in place of "?"`);
      kept.push(row);
    }
  }
  for (const [, left] of listed) for (const row of write ? [] : left) wrong.push(`${list} has "${row[3]}", which ${row[1]} does not show: run tests/figures/figures.mjs with --write`);
  if (write) writeFileSync(list, `${kept.map((row) => row.join('\t')).join('\n')}\n`);
  const count = { limit: 0, source: 0, command: 0 };
  for (const row of kept) count[row[2] in count ? row[2] : 'command'] += 1;
  return { wrong, count, oldest: kept.filter((row) => !(row[2] in count)).map((row) => row[0]).sort()[0] };
}
