// Figures in Markdown that a command prints anew: figures.mjs BIN [--write]. A figure stands between two comments,
// "figures NAME" and "end", alone or within a line. Each is compared with what its command prints today, to the digit
// where the command is deterministic. --write puts today's there: look at the difference, and commit it.
//
// A figure that takes minutes is not computed here. The same text must stand at each of its places, so that nobody
// renews one and forgets another. Figures outside the marks are in listed.txt (prose.mjs), which --write brings up to date.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { checkProse } from './prose.mjs';

const [bin, how] = process.argv.slice(2);
const root = normalize(join(dirname(fileURLToPath(import.meta.url)), '../..'));
const work = mkdtempSync(join(tmpdir(), 'figures-'));
process.on('exit', () => rmSync(work, { recursive: true, force: true }));

const signed = (value) => (value > 0 ? `+${value}` : `${value}`.replace('-', '−'));
function factsOf(...args) {
  const file = join(work, 'facts.json');
  execFileSync(join(bin, 'enamel-station'), [...args, '--json', file], { stdio: 'ignore', timeout: 300_000 });
  return JSON.parse(readFileSync(file, 'utf8'));
}

const kPlanes = ['mesial', 'distal', 'buccal', 'lingual', 'floor'];
function simulated(device, profile, operator) {
  const facts = factsOf('simulate', '--profile', profile, '--operator', operator, '--voxel-um', '100');
  const walls = kPlanes.map((plane) => signed(Math.round(facts.plane_median_um[plane])));
  const force = `${facts.force_p95_n.toFixed(1)}, ${facts.force_max_n.toFixed(1)} N`;
  return `| ${device}, \`${operator}\` | ${walls.join(' | ')} | ${force} |`;
}

// What a command prints, by name.
const kPrinted = {
  simulate: () =>
    [
      '',
      `| device, operator | ${kPlanes.join(' | ')} | force p95, max |`,
      '|---|--:|--:|--:|--:|--:|---|',
      simulated('Phantom Desktop', 'phantom_desktop', 'dentist'),
      simulated('Phantom Desktop', 'phantom_desktop', 'student-deep-mesial'),
      simulated('Omega', 'omega3', 'dentist'),
      simulated('BHhd', 'bhhd3', 'dentist'),
      '',
    ].join('\n'),
};
// Minutes: the command, and when it last printed what stands there.
const kDated = {
  'strokes phantom_desktop': ['enamel-lab qualify --suite strokes --profile all', '2026-11-29'],
  'strokes omega3': ['enamel-lab qualify --suite strokes --profile all', '2026-11-29'],
  'strokes bhhd3': ['enamel-lab qualify --suite strokes --profile all', '2026-11-29'],
  'strokes inverse3': ['enamel-lab qualify --suite strokes --profile all', '2026-11-29'],
  'storage year': ['enamel-lab bench storage --quick', '2026-11-30'],
};

let failed = 0;
const wrong = (text) => {
  console.error(`FAILED: ${text}`);
  failed = 1;
};
const isMarkdown = (name) => name.endsWith('.md');
const files = readdirSync(root).filter(isMarkdown);
for (const folder of ['common', 'docs', 'schemas', 'server', 'station', 'tests'])
  files.push(...readdirSync(join(root, folder), { recursive: true }).filter(isMarkdown).map((name) => join(folder, name)));
const kMark = /(<!-- figures ([^>]+?) -->)([\s\S]*?)(<!-- end -->)/g;
const seen = new Map();
for (const file of files) {
  const text = readFileSync(join(root, file), 'utf8');
  for (const [, , name, value] of text.matchAll(kMark)) seen.set(name, [...(seen.get(name) ?? []), { file, value }]);
}
for (const name of [...Object.keys(kPrinted), ...Object.keys(kDated)])
  if (!seen.has(name)) wrong(`no Markdown shows the figure "${name}"`);
for (const [name, places] of seen) {
  if (kDated[name]) {
    if (new Set(places.map((p) => p.value)).size > 1)
      wrong(`"${name}" has several values, ${kDated[name][0]} prints it:\n${places.map((p) => `  ${p.file}: ${p.value}`).join('\n')}`);
    continue;
  }
  if (!kPrinted[name]) {
    wrong(`${places[0].file}: no command prints the figure "${name}"; add one to tests/figures/figures.mjs`);
    continue;
  }
  const today = kPrinted[name]();
  for (const { file, value } of places) {
    if (value === today) continue;
    if (how === '--write') {
      const path = join(root, file);
      writeFileSync(path, readFileSync(path, 'utf8').replace(kMark, (all, begin, of, old, end) => (of === name ? begin + today + end : all)));
      console.log(`${file}: ${name} written`);
    } else {
      wrong(`${file}: "${name}" shows${value}but its command prints${today}run tests/figures/figures.mjs build/release/bin --write`);
    }
  }
}
console.log(`${seen.size} figures, ${Object.keys(kPrinted).length} of them computed anew; computed by hand:`);
for (const [name, [command, date]] of Object.entries(kDated)) console.log(`  ${name}: ${command}, ${date}`);
const prose = checkProse(root, join(root, 'tests/figures/listed.txt'), how === '--write');
for (const text of prose.wrong) wrong(text);
const { limit, source, command } = prose.count;
console.log(`Paragraphs and rows with a figure outside the marks: ${command} name the command that printed it, the oldest on ${prose.oldest};`);
console.log(`${source} name a source; ${limit} are limits that programs keep to, or instructions.`);
process.exit(failed);
