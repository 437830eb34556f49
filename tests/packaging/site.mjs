// The guides as a site: site.mjs FOLDER makes it of what enamel-doc has installed in FOLDER, as packages have it. Every link in it leads to a page, to a heading of it or to a file
// there; no Markdown is left in what is read; tags are closed; the search finds what people ask for, in three languages;
// every operation of the API is in its table.
import { existsSync, readFileSync } from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { makeSite } from '../../packaging/site/make.mjs';

const root = process.argv[2];
const out = join(root, 'html');
let failed = 0;
const wrong = (page, text) => {
  console.error(`FAILED: ${page}: ${text}`);
  failed = 1;
};

const kAlone = new Set(['meta', 'link', 'input', 'img', 'br']);
function checkTags(page, html) {
  const open = [];
  for (const [, close, tag] of html.replace(/<script[\s\S]*?<\/script>/g, '').matchAll(/<(\/?)([a-z][a-z0-9]*)\b[^>]*>/g)) {
    if (kAlone.has(tag)) continue;
    if (!close) open.push(tag);
    else if (open.pop() !== tag) return wrong(page, `</${tag}> closes nothing`);
  }
  if (open.length > 0) wrong(page, `<${open.at(-1)}> is not closed`);
}

const pages = await makeSite(root, out);
const html = new Map(pages.map((page) => [page, readFileSync(join(out, page), 'utf8')]));
const ids = new Map([...html].map(([page, text]) => [page, new Set([...text.matchAll(/ id="([^"]+)"/g)].map((m) => m[1]))]));
let links = 0;
for (const [page, text] of html) {
  checkTags(page, text);
  const main = text.match(/<main>([\s\S]*)<\/main>/)[1].replace(/<(pre|code)>[\s\S]*?<\/\1>/g, '');
  const left = main.replace(/<[^>]*>/g, ' ').match(/.{0,30}(\*\*|`|\]\(|\|\s*:?--|^#+ |^\s*\* ).{0,30}/m);
  if (left) wrong(page, `Markdown is left: "${left[0].trim()}"`);
  for (const [, target] of text.matchAll(/ (?:href|src)="([^"]+)"/g)) {
    if (/^[a-z]+:/.test(target)) continue;
    ++links;
    const [path, anchor] = decodeURI(target).split('#');
    const at = relative(out, path ? join(out, dirname(page), path) : join(out, page));
    const isPage = html.has(at);
    if (!isPage && !existsSync(join(out, at))) wrong(page, `a link to ${target}, which is not there`);
    if (anchor && isPage && !ids.get(at).has(anchor)) wrong(page, `${at} has no heading #${anchor}`);
  }
  if (/(href|src)="https?:[^"]*"/.test(text.replace(/<main>[\s\S]*<\/main>/, ''))) wrong(page, 'loads something from elsewhere');
}

(0, eval)(readFileSync(join(out, 'index.js'), 'utf8'));
const asked = { 'restore backup': ['en', 'docs/for_it.html'], 'mirror size': ['en', 'docs/first_week.html'], 'csrf curl': ['en', 'docs/api.html'], Einspruch: ['de', 'docs/de/first_week.html'], 考试: ['zh', 'docs/zh/first_exam.html'], 'enrol-code': ['en', 'docs/for_it.html'] };
for (const [question, [language, page]] of Object.entries(asked)) {
  const hits = globalThis.enamelSearch.find(globalThis.enamelIndex, question, language).slice(0, 5);
  if (!hits.some(([at]) => at === page)) wrong('search', `"${question}" finds ${hits.map(([at, id]) => `${at}#${id}`).join(', ') || 'nothing'}, not ${page}`);
}
if (globalThis.enamelSearch.find(globalThis.enamelIndex, 'zebra backup', 'en').length > 0) wrong('search', 'finds a word that no page has');
const operations = readFileSync(join(root, 'schemas/api/openapi.yaml'), 'utf8').match(/^ {6}operationId: /gm).length;
const listed = html.get('docs/api_paths.html').match(/<tr><td>/g).length;
if (operations !== listed) wrong('docs/api_paths.html', `has ${listed} operations, the contract ${operations}`);
console.log(`${pages.length} pages, ${links} links, ${globalThis.enamelIndex.sections.length} sections`);
process.exit(failed);
