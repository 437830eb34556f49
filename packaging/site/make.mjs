// The guides and formats as a static site: make.mjs ROOT OUT. It makes a page of each Markdown that enamel-doc has, one of the API's
// paths, navigation, and an index for the search. OUT is meant to be the folder "html" of ROOT: a page leads to pictures and other
// files where ROOT has them. The site needs no server and loads nothing from elsewhere: search.js and index.js are scripts, because
// a browser lets no page of a disk fetch data.
import { copyFileSync, existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { headingsOf, htmlOf, textOf } from './markdown.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const kFolders = ['docs', 'schemas', 'server', 'station', 'common', 'web', 'tests'];
const kApi = 'docs/api_paths.md'; // made of the contract; there is no such Markdown

const escaped = (text) => text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/"/g, '&quot;');
const pageOf = (file) => file.replace(/\.md$/, '.html');
const languageOf = (file) => file.match(/^docs\/(\w\w)\//)?.[1] ?? 'en';

// What enamel-doc has of Markdown: packaging/CMakeLists.txt.
export function textsOf(root) {
  const below = (folder) => readdirSync(join(root, folder), { withFileTypes: true }).flatMap((entry) =>
    entry.isDirectory() ? (/^(golden|node_modules|dist.*|corpus)$/.test(entry.name) ? [] : below(join(folder, entry.name))) : [join(folder, entry.name)]);
  const all = [...readdirSync(root), ...kFolders.filter((folder) => existsSync(join(root, folder))).flatMap(below)];
  return all.filter((file) => file.endsWith('.md')).sort();
}

// Every operation of the contract, as Markdown. The contract is YAML; four kinds of its lines are all that is needed.
export function apiMarkdown(contract) {
  const rows = [];
  let path = '';
  let row;
  for (const line of contract.split('\n')) {
    const operation = line.match(/^ {4}(get|put|post|patch|delete):$/);
    if (/^ {2}\/\S*:$/.test(line)) path = line.trim().slice(0, -1);
    else if (/^\S/.test(line)) path = '';
    else if (path && operation) rows.push((row = { path, method: operation[1].toUpperCase(), summary: '', may: 'everybody' }));
    else if (path && row && /^ {6}summary: /.test(line)) row.summary = line.slice(15).replace(/^['"]|['"]$/g, '');
    else if (path && row && /^ {6}x-may: \{/.test(line)) row.may = line.trim().slice(8, -1);
  }
  const cell = (text) => text.replace(/\|/g, '\\|');
  return [
    '# The paths of the API', '',
    'Made of [the contract](../schemas/api/openapi.yaml), which has parameters and answers. [A program that uses the API](api.md) begins with curl.', '',
    '| method | path | what it does | who may |', '|---|---|---|---|',
    ...rows.map(({ path: at, method, summary, may }) => `| ${method} | \`${at}\` | ${cell(summary)} | ${cell(may)} |`),
  ].join('\n');
}

// Sections with where they are, and for each word the numbers of the sections that have it.
export function indexOf(pages) {
  const sections = [];
  const words = new Map();
  for (const { file, markdown } of pages) {
    const heads = headingsOf(markdown);
    for (const { id, title, text } of heads) {
      const number = sections.length;
      sections.push([pageOf(file), id, heads[0].title, title, `${textOf(text).slice(0, 160)}…`, languageOf(file)]);
      for (const word of new Set(globalThis.enamelSearch.words(`${title} ${textOf(text)}`))) words.set(word, [...(words.get(word) ?? []), number]);
    }
  }
  return { sections, words: Object.fromEntries([...words].sort()) };
}

// Links of the guides' list, by reader, and what is looked up.
function navigation(root, file) {
  const to = (target) => escaped(relative(dirname(pageOf(file)), pageOf(target)));
  const link = (target, text) => `<li><a href="${to(target)}"${target === file ? ' aria-current="page"' : ''}>${escaped(text)}</a></li>`;
  const titleOf = (name) => headingsOf(readFileSync(join(root, name), 'utf8'))[0].title;
  const guides = [...readFileSync(join(root, 'docs/README.md'), 'utf8').matchAll(/\[([^\]]+)\]\((?!\.\.)([\w/]+\.md)\)/g)]
    .map(([, text, target]) => link(`docs/${target}`, target.includes('/') ? titleOf(`docs/${target}`) : text[0].toUpperCase() + text.slice(1)));
  const formats = textsOf(root).filter((name) => name.startsWith('schemas/'))
    .map((name) => link(name, titleOf(name)));
  return `<h2>Guides</h2><ul>${guides.join('')}</ul><h2>To look up</h2><ul>${link(kApi, 'Paths of the API')}${link('CHANGELOG.md', 'Changelog')}${link('server/README.md', 'Server')}${link('station/README.md', 'Station')}${link('tests/bench/README.md', 'Measurements')}</ul><details><summary>Formats</summary><ul>${formats.join('')}</ul></details>`;
}

function wholePage(root, { file, markdown }, made) {
  const up = relative(dirname(pageOf(file)), '.') || '.';
  // A Markdown becomes its page; anything else is where it was, one folder above the site.
  const href = (target) => {
    if (/^([a-z]+:|#)/.test(target)) return target;
    const [path, anchor] = target.split('#');
    const at = join(dirname(file), path);
    const to = made.has(at) ? relative(dirname(pageOf(file)), pageOf(at)) : relative(join('html', dirname(file)), at);
    return anchor ? `${to}#${anchor}` : to;
  };
  return `<!doctype html>
<html lang="${languageOf(file)}">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>${escaped(headingsOf(markdown)[0].title)} – Enamel</title>
<link rel="stylesheet" href="${up}/style.css">
<body data-up="${up}">
<header><a href="${up}/docs/README.html">Enamel</a><input id="search" type="search" placeholder="Search the guides" aria-label="Search the guides"></header>
<div id="found" role="status" hidden></div>
<div id="page"><nav aria-label="Guides">${navigation(root, file)}</nav><main>${htmlOf(markdown, href)}</main></div>
<script src="${up}/index.js"></script>
<script src="${up}/search.js"></script>
</body>
</html>
`;
}

export async function makeSite(root, out) {
  await import(pathToFileURL(join(here, 'search.js')).href);
  const pages = textsOf(root).map((file) => ({ file, markdown: readFileSync(join(root, file), 'utf8') }));
  pages.push({ file: kApi, markdown: apiMarkdown(readFileSync(join(root, 'schemas/api/openapi.yaml'), 'utf8')) });
  const made = new Set(pages.map(({ file }) => file));
  for (const page of pages) {
    mkdirSync(join(out, dirname(page.file)), { recursive: true });
    writeFileSync(join(out, pageOf(page.file)), wholePage(root, page, made));
  }
  writeFileSync(join(out, 'index.html'), '<!doctype html>\n<meta charset="utf-8">\n<title>Enamel</title>\n<meta http-equiv="refresh" content="0; url=docs/README.html">\n<a href="docs/README.html">Guides</a>\n');
  writeFileSync(join(out, 'index.js'), `globalThis.enamelIndex = ${JSON.stringify(indexOf(pages))};\n`);
  for (const file of ['style.css', 'search.js']) copyFileSync(join(here, file), join(out, file));
  return pages.map(({ file }) => pageOf(file));
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) await makeSite(process.argv[2], process.argv[3]);
