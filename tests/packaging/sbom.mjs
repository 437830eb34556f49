// The lists of each package's parts: sbom.mjs BUILD. They have the shape of CycloneDX 1.5, and name every library that
// a program needs and every npm package that the page's sources import.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

const build = process.argv[2];
const root = normalize(join(dirname(fileURLToPath(import.meta.url)), '../..'));
const read = (program, args) => execFileSync(program, args, { encoding: 'utf8', maxBuffer: 1 << 26, stdio: ['ignore', 'pipe', 'ignore'] });
try {
  read('dpkg', ['--version']);
  read('readelf', ['--version']);
} catch {
  console.log('skipped: dpkg or readelf is not installed');
  process.exit(77);
}

let failed = 0;
const wrong = (text) => {
  console.error(`FAILED: ${text}`);
  failed = 1;
};
const out = mkdtempSync(join(tmpdir(), 'sbom_'));
const make = (folder) => execFileSync('node', [join(root, 'packaging/sbom.mjs'), build, folder, '0.1.0~1.abc', 'abc', '1700000000'], { stdio: 'inherit' });
make(out);

const documents = new Map();
for (const name of readdirSync(out)) documents.set(name.replace('.cdx.json', ''), JSON.parse(readFileSync(join(out, name), 'utf8')));
const packages = ['enamel-import-child', 'enamel-lab', 'enamel-page', 'enamel-server', 'enamel-station'];
if ([...documents.keys()].join() !== packages.join()) wrong(`made ${[...documents.keys()]}, expected ${packages}`);

const kPurl = /^pkg:(deb\/[a-z]+|npm|generic)\/[A-Za-z0-9.%+_/-]+@[A-Za-z0-9.%:~_-]+(\?[a-z_]+=[A-Za-z0-9.%:~_-]+(&[a-z_]+=[A-Za-z0-9.%:~_-]+)*)?$/;
function checkComponent(name, component) {
  for (const field of ['bom-ref', 'type', 'name', 'version', 'purl']) {
    if (typeof component[field] !== 'string' || component[field] === '') wrong(`${name}: a component without ${field}`);
  }
  if (!['application', 'library'].includes(component.type)) wrong(`${name}: type ${component.type}`);
  if (!kPurl.test(component.purl)) wrong(`${name}: ${component.purl} is no package URL`);
  for (const { alg, content } of component.hashes ?? []) {
    if (alg !== 'SHA-512' || !/^[0-9a-f]{128}$/.test(content)) wrong(`${name}: ${component.name} has a wrong hash`);
  }
}
for (const [name, document] of documents) {
  if (document.bomFormat !== 'CycloneDX' || document.specVersion !== '1.5' || document.version !== 1) wrong(`${name}: not CycloneDX 1.5`);
  if (!/^urn:uuid:[0-9a-f]{8}-[0-9a-f]{4}-[1-8][0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$/.test(document.serialNumber)) {
    wrong(`${name}: serialNumber ${document.serialNumber}`);
  }
  if (document.metadata.timestamp !== '2023-11-14T22:13:20Z') wrong(`${name}: made at ${document.metadata.timestamp}, and not at the time given`);
  if (document.metadata.component.name !== name) wrong(`${name}: describes ${document.metadata.component.name}`);
  const all = [document.metadata.component, ...document.components];
  for (const component of all) checkComponent(name, component);
  const refs = new Set(all.map((component) => component['bom-ref']));
  if (refs.size !== all.length) wrong(`${name}: two components have one bom-ref`);
  const described = document.dependencies.map(({ ref }) => ref);
  if ([...refs].sort().join() !== [...described].sort().join()) wrong(`${name}: dependencies are not of the components`);
  for (const { dependsOn } of document.dependencies) for (const ref of dependsOn) if (!refs.has(ref)) wrong(`${name}: depends on ${ref}, which it lacks`);
}

// Whose file a library is that a program needs.
const names = (name) => new Set(documents.get(name).components.map((component) => component.name));
const needed = new Map(packages.filter((name) => name !== 'enamel-page').map((program) => [
  program, [...read('readelf', ['-d', join(build, 'bin', program)]).matchAll(/\(NEEDED\).*\[(.*)\]/g)].map((m) => m[1]),
]));
const owners = new Map();
for (const line of read('dpkg', ['-S', ...new Set([...needed.values()].flat().map((library) => `*/${library}`))]).split('\n')) {
  const library = line.replace(/.*\//, '');
  owners.set(library, [...(owners.get(library) ?? []), line.split(':')[0]]);
}
for (const [program, libraries] of needed) {
  if (libraries.length < 4) wrong(`${program} needs only ${libraries}`);
  for (const library of libraries) {
    if (!owners.get(library).some((owner) => names(program).has(owner))) wrong(`${program} needs ${library} of ${owners.get(library)}, which is not in its list`);
  }
}
// Only in headers or archives, so the loader does not know them.
for (const [program, inside] of [['enamel-server', 'libcli11-dev'], ['enamel-server', 'libpq-dev'], ['enamel-station', 'libimgui-dev']]) {
  if (!names(program).has(inside)) wrong(`${program} lacks ${inside}, whose code is compiled into it`);
}
const sources = readdirSync(join(root, 'web/src'), { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile() && /\.tsx?$/.test(entry.name) && !/\.test\.tsx?$/.test(entry.name));
const imports = new Set();
for (const entry of sources) {
  const text = readFileSync(join(entry.path, entry.name), 'utf8');
  for (const [, path] of text.matchAll(/(?:\bfrom|\bimport\(?)\s*"((?:@[\w-]+\/)?[a-z][\w-]*)(?:\/[^"]*)?"/g)) imports.add(path);
}
if (!imports.has('preact')) wrong('found no import of preact in web/src');
for (const name of imports) if (!names('enamel-page').has(name)) wrong(`the page imports ${name}, and its list does not have it`);

// Equal packages have equal lists.
const again = mkdtempSync(join(tmpdir(), 'sbom_'));
make(again);
for (const name of readdirSync(out)) {
  if (readFileSync(join(out, name), 'utf8') !== readFileSync(join(again, name), 'utf8')) wrong(`${name} differs between two runs`);
}
for (const folder of [out, again]) rmSync(folder, { recursive: true });
console.log([...documents].map(([name, { components }]) => `${name}: ${components.length}`).join(', '));
process.exit(failed);
