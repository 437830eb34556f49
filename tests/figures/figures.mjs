// Figures in Markdown that a command prints anew: figures.mjs BIN [--write]. A figure stands between two comments,
// "figures NAME" and "end", alone or within a line. Each is compared with what its command prints today, to the digit
// where the command is deterministic. --write puts today's there: look at the difference, and commit it.
//
// A figure that takes minutes is not computed here: it names its command and its date. The same text must stand at each of its
// places, so that nobody renews one and forgets another. Figures outside the marks are in listed.txt (prose.mjs), which --write
// brings up to date.
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
const table = (head, align, rows) => ['', head, align, ...rows, ''].join('\n');
function factsOf(program, ...args) {
  const file = join(work, 'facts.json');
  execFileSync(join(bin, program), [...args, '--json', file], { stdio: 'ignore', timeout: 300_000 });
  return JSON.parse(readFileSync(file, 'utf8'));
}

const kPlanes = ['mesial', 'distal', 'buccal', 'lingual', 'floor'];
function simulated(device, profile, operator) {
  const facts = factsOf('enamel-station', 'simulate', '--profile', profile, '--operator', operator, '--voxel-um', '100');
  const walls = kPlanes.map((plane) => signed(Math.round(facts.plane_median_um[plane])));
  const force = `${facts.force_p95_n.toFixed(1)}, ${facts.force_max_n.toFixed(1)} N`;
  return `| ${device}, \`${operator}\` | ${walls.join(' | ')} | ${force} |`;
}

// The figure of one motion on each device, with its bound where it has one.
function motion(devices, text, motion, name, factor, digits) {
  const shown = devices.map(({ cases }) => {
    const { value, bound, held } = cases.find((c) => c.name === motion).tracks.find((t) => t.default).figures.find((f) => f.name === name);
    const figure = (factor * value).toFixed(digits);
    return `${held ? figure : `**${figure}**`}${bound === null ? '' : ` (${(factor * bound).toFixed(digits)})`}`;
  });
  return `| ${text} | ${shown.join(' | ')} |`;
}

// The depth of short touches at both rates, of the devices that the page compares.
function touched(rows, device) {
  const share = (column, rate) => rows.find((row) => row[0] === device && row[1] === 'yes' && row[2] === rate)[column].split(' ')[0];
  return `| ${device} | ${[5, 6].flatMap((column) => [share(column, '1'), share(column, '4')]).join(' | ')} |`;
}

const kTouched = ['Omega 3DOF', 'sigma.7', 'BHhd 3DOF', 'Phantom Desktop', 'omega.6', 'omega.7', 'Haply Inverse3', '3D Systems Touch'];

// The calibrated error of a device, from the dated table.
const strokesOf = (device) => seen.get('strokes')[0].value.match(new RegExp(`\\| ${device} \\| \\d+ \\| \\*\\*(\\d+)`))[1];

// What a command prints, by name.
const kPrinted = {
  simulate: () =>
    table(`| device, operator | ${kPlanes.join(' | ')} | force p95, max |`, '|---|--:|--:|--:|--:|--:|---|', [
      simulated('Phantom Desktop', 'phantom_desktop', 'dentist'),
      simulated('Phantom Desktop', 'phantom_desktop', 'student-deep-mesial'),
      simulated('Omega', 'omega3', 'dentist'),
      simulated('BHhd', 'bhhd3', 'dentist'),
    ]),
  withdrawal: () => {
    const devices = ['omega3', 'phantom_desktop', 'bhhd3'].map(
      (profile) => factsOf('enamel-lab', 'qualify', '--suite', 'withdrawal', '--profile', profile).strokes.devices[0],
    );
    return table(`| | ${devices.map((d) => d.title).join(' | ')} |`, '|---|--:|--:|--:|', [
      motion(devices, 'press: behind the ideal at half height, ms', 'press', 'lag_s', 1000, 0),
      motion(devices, 'press: time to 90 %, ms', 'press', 'rise90_s', 1000, 0),
      motion(devices, 'stroke: above the ideal, N', 'stroke', 'overshoot_n', 1, 2),
      motion(devices, 'reverse: pull against the hand, N', 'reverse', 'pull_n', 1, 2),
      motion(devices, 'lift: pull against the hand, N', 'lift', 'pull_n', 1, 2),
      motion(devices, 'reverse: pushes the hand along, ms', 'reverse', 'help_s', 1000, 0),
      motion(devices, 'reverse: lets go, ms', 'reverse', 'let_go_s', 1000, 0),
      motion(devices, 'lift, sideways, while the bur is still in the slot: lets go, ms', 'lift', 'let_go_s', 1000, 0),
      motion(devices, 'nick: lets go, ms', 'nick', 'let_go_s', 1000, 0),
      motion(devices, 'slip-out: lets go, ms', 'slip-out', 'let_go_s', 1000, 0),
      motion(devices, 'press: a step of the force beyond Kc (v T + √3 δ), N', 'press', 'step_beyond_n', 1, 3),
    ]);
  },
  pecks: () => {
    const { rows } = factsOf('enamel-lab', 'qualify', '--suite', 'pecks', '--profile', 'all').report.sections[0].tables[0];
    return table('| device | B 0.89 | at 4 kHz | B 0.10 | at 4 kHz |', '|---|--:|--:|--:|--:|', kTouched.map((device) => touched(rows, device)));
  },
  'strokes phantom_desktop': () => strokesOf('Phantom Desktop'),
  'strokes omega3': () => strokesOf('Omega 3DOF'),
  'strokes bhhd3': () => strokesOf('BHhd 3DOF'),
  'strokes inverse3': () => strokesOf('Haply Inverse3'),
};
// Minutes: the command, and when it last printed what stands there. At most this many: nobody may have looked since.
const kMaxDated = 10;
const kDated = {
  strokes: ['enamel-lab qualify --suite strokes --profile all', '2026-11-29'],
  'stiffest grips': ['enamel-lab qualify --suite map --profile all --quick', '2026-11-30'],
  'storage year': ['enamel-lab bench storage --quick', '2026-11-30'],
  'chair network': ['enamel-lab bench record --hours 8', '2026-11-30'],
  skill: ['enamel-lab operators --device omega3 --exercise crown', '2026-11-28'],
  load: ['enamel-loadgen --stations 1000 --minutes 5 --loop-seconds 5', '2026-11-21'],
  'attempt scored': ['enamel-lab bench score', '2026-11-30'],
  'server restart': ['tests/faults/kill_bench.sh 200', '2026-11-30'],
  'cluster faults': ['tests/cluster/run.sh --full --only faults', '2026-11-23'],
  patroni: ['ENAMEL_FULL=1 tests/cluster/patroni.sh', '2026-11-23'],
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
if (Object.keys(kDated).length > kMaxDated) wrong(`more than ${kMaxDated} figures are dated: compute them, or leave them out of the text`);
for (const [name, [command, date]] of Object.entries(kDated))
  if (!/^(ENAMEL_\w+=\S+ )?(enamel-\w+|node|tests\/\S+) \S|\.sh$/.test(command) || !/^\d{4}-\d\d-\d\d$/.test(date)) wrong(`"${name}" names no command or no date`);
for (const file of files) {
  const text = readFileSync(join(root, file), 'utf8');
  for (const [, , name, value] of text.matchAll(kMark)) seen.set(name, [...(seen.get(name) ?? []), { file, value }]);
}
for (const name of [...Object.keys(kPrinted), ...Object.keys(kDated)])
  if (!seen.has(name)) wrong(`no Markdown shows the figure "${name}"`);
for (const [name, places] of seen) {
  if (kDated[name]) {
    if (new Set(places.map((p) => p.value.replace(/\s+/g, ' '))).size > 1)
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
console.log(`Paragraphs and rows with a figure outside the marks, none of them measured: ${JSON.stringify(prose.count)}`);
process.exit(failed);
