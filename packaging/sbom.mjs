// Lists the parts of each package, in CycloneDX 1.5: sbom.mjs BUILD OUT VERSION COMMIT TIME
// For a program of ours: the Debian packages that it links, those whose code was compiled into it (from the build's own list
// of the headers and archives that each object needs), and the packages that it opens at run time, which are compiled
// in as headers. For the page: the npm packages that web/package-lock.json has for use.
// TIME is in seconds since 1970. Two runs over one build write the same bytes.
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdirSync, readFileSync, realpathSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const [build, out, version, commit, time] = process.argv.slice(2);
const root = resolve(dirname(fileURLToPath(import.meta.url)), '..');
const programs = ['enamel-server', 'enamel-station', 'enamel-lab', 'enamel-import-child'];

function run(program, args) {
  return execFileSync(program, args, { encoding: 'utf8', maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'ignore'] });
}

// The Debian packages that have these files.
function packagesOf(paths) {
  const found = new Set();
  // dpkg knows a file by the path that its package gave it, which may lack /usr.
  const names = [...new Set(paths.flatMap((path) => [realpathSync(path), realpathSync(path).replace(/^\/usr/, '')]))];
  let text = '';
  try {
    text = run('dpkg', ['-S', ...names]);
  } catch (error) {
    text = error.stdout;  // it fails when one of two names is unknown
  }
  for (const [, owners] of text.matchAll(/^([^/]+): \//gm)) {
    for (const owner of owners.split(', ')) found.add(owner.trim());
  }
  return [...found].sort();
}

const described = new Map();
function describe(name) {
  if (!described.has(name)) {
    const format = '${Package}\\t${Version}\\t${Architecture}\\t${source:Package}\\t${source:Version}';
    const [pkg, ver, arch, source, sourceVersion] = run('dpkg-query', ['-W', '-f', format, name]).split('\t');
    described.set(name, { pkg, ver, arch, source, sourceVersion });
  }
  return described.get(name);
}

const release = readFileSync('/etc/os-release', 'utf8');
const [, distro] = release.match(/^ID="?([a-z]+)/m);
const [, distroVersion] = release.match(/^VERSION_ID="?([0-9.]+)/m) ?? [undefined, ''];
const encoded = (text) => encodeURIComponent(text).replace(/%3A/g, ':');

function debianComponent(name, use) {
  const { pkg, ver, arch, source, sourceVersion } = describe(name);
  const upstream = source === pkg && sourceVersion === ver ? source : `${source}@${sourceVersion}`;
  const purl = `pkg:deb/${distro}/${encoded(pkg)}@${encoded(ver)}?arch=${arch}&distro=${distro}-${distroVersion}&upstream=${encoded(upstream)}`;
  return { 'bom-ref': purl, type: 'library', name: pkg, version: ver, purl, properties: [{ name: 'enamel:use', value: use }] };
}

// Libraries that the loader reads with the program, as the program itself names them.
function linked(program) {
  const file = join(build, 'bin', program);
  const needed = new Set([...run('readelf', ['-d', file]).matchAll(/\(NEEDED\).*\[(.*)\]/g)].map((m) => m[1]));
  const paths = [...run('ldd', [file]).matchAll(/^\s*(\S+)(?: => (\S+))? \(/gm)]
    .filter(([, name]) => needed.has(name) || needed.has(name.replace(/.*\//, '')))
    .map(([, name, path]) => path ?? name);
  if (paths.length < needed.size) throw new Error(`${program}: found ${paths.length} of its ${needed.size} libraries`);
  return packagesOf(paths);
}

// Headers by the object that read them.
function headersByObject() {
  const headers = new Map();
  let object = '';
  for (const line of run('ninja', ['-C', build, '-t', 'deps']).split('\n')) {
    const start = line.match(/^(\S+): #deps/);
    if (start) headers.set((object = start[1]), []);
    else if (line.startsWith('    /usr/')) headers.get(object).push(line.trim());
  }
  return headers;
}

// The compiler's own: a program's libstdc++ and libc are among the linked ones.
const toolchain = /^(libc6-dev|linux-libc-dev|libstdc\+\+-\d+-dev|libgcc-\d+-dev|libcrypt-dev)(:|$)/;
const headers = headersByObject();
function compiledIn(program) {
  const inputs = run('ninja', ['-C', build, '-t', 'inputs', `bin/${program}`]).split('\n');
  const files = inputs.filter((path) => /^\/usr\/.*\.a$/.test(path));
  for (const path of inputs) files.push(...(headers.get(path) ?? []));
  if (files.length === 0) throw new Error(`${program}: the build has no list of headers; build it first`);
  return packagesOf([...new Set(files)]).filter((name) => !toolchain.test(name));
}

function programComponents(program) {
  const shared = linked(program);
  const sources = new Set(shared.map((name) => describe(name).source));
  // Headers of a library that is linked add nothing: a flaw is fixed in the same source.
  const inside = compiledIn(program).filter((name) => !sources.has(describe(name).source));
  return [...shared.map((name) => debianComponent(name, 'linked')), ...inside.map((name) => debianComponent(name, 'compiled in'))];
}

function npmComponents() {
  const lock = JSON.parse(readFileSync(join(root, 'web/package-lock.json'), 'utf8'));
  return Object.entries(lock.packages)
    .filter(([path, entry]) => path !== '' && !entry.dev)
    .map(([path, entry]) => {
      const name = path.replace(/^.*node_modules\//, '');
      const purl = `pkg:npm/${name.replace('@', '%40')}@${entry.version}`;
      const hash = Buffer.from(entry.integrity.replace(/^sha512-/, ''), 'base64').toString('hex');
      return {
        'bom-ref': purl, type: 'library', name, version: entry.version, purl,
        licenses: [{ license: { id: entry.license } }],
        hashes: [{ alg: 'SHA-512', content: hash }],
        properties: [{ name: 'enamel:use', value: 'bundled' }],
      };
    });
}

function write(name, components) {
  const purl = `pkg:generic/${name}@${encoded(version)}?vcs_ref=${commit}`;
  const document = {
    bomFormat: 'CycloneDX',
    specVersion: '1.5',
    version: 1,
    metadata: {
      timestamp: new Date(Number(time) * 1000).toISOString().replace('.000', ''),
      component: {
        'bom-ref': purl, type: 'application', name, version, purl,
        licenses: [{ license: { id: 'Apache-2.0' } }],
        properties: [{ name: 'enamel:commit', value: commit }],
      },
    },
    components,
    dependencies: [
      { ref: purl, dependsOn: components.map((component) => component['bom-ref']) },
      ...components.map((component) => ({ ref: component['bom-ref'], dependsOn: [] })),
    ],
  };
  // The number follows from the content, in the form of a UUID (RFC 9562, version 8).
  const hash = createHash('sha256').update(JSON.stringify(document)).digest('hex');
  const uuid = [hash.slice(0, 8), hash.slice(8, 12), `8${hash.slice(13, 16)}`, `8${hash.slice(17, 20)}`, hash.slice(20, 32)];
  const text = JSON.stringify({ ...document, serialNumber: `urn:uuid:${uuid.join('-')}` }, null, 2);
  writeFileSync(join(out, `${name}.cdx.json`), `${text}\n`);
}

mkdirSync(out, { recursive: true });
for (const program of programs) write(program, programComponents(program));
write('enamel-page', npmComponents());
