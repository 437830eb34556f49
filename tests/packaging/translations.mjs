// Guides in German and Chinese. A translation has the headings, steps, tables, pictures, links, blocks and code of the English guide, and
// names the checksum of the English text that it was made of: who changes a guide looks at its translations.
import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { withoutBlocks } from './links.mjs';

const kLanguages = ['de', 'zh'];
const kInAnyOrder = new Set(['links', 'code']); // a sentence names things in the order of its language

export const languageOf = (file) => file.match(/^docs\/(\w\w)\//)?.[1] ?? 'en';

export function translatedGuides(root) {
  return kLanguages.flatMap((language) =>
    readdirSync(join(root, 'docs', language)).filter((name) => name.endsWith('.md')).map((name) => `docs/${language}/${name}`),
  );
}

// What people see in each language: texts of page, window and built-in exercises.
export function shownTexts(root) {
  const textsOf = (language) => ['page', 'window', 'exercise'].flatMap((name) =>
    Object.values(JSON.parse(readFileSync(join(root, `schemas/words/${language}/${name}.json`), 'utf8')).messages),
  );
  return Object.fromEntries(['en', ...kLanguages].map((language) => [language, textsOf(language)]));
}

function shapeOf(file, text) {
  // A link leads to the original or to its translation. The heading that it names differs with the language.
  const target = (path) => join(dirname(file), path.split('#')[0]).replace(/^docs\/\w\w\//, 'docs/');
  const all = (pattern, of) => [...text.matchAll(pattern)].map(of);
  return {
    headings: all(/^#+ /gm, (m) => m[0]),
    steps: all(/^(\d+\.|\*) /gm, (m) => m[1]),
    'rows of tables': all(/^\|.*$/gm, (m) => `${m[0].split('|').length - 2} cells`),
    pictures: all(/!\[[^\]]*\]\(([^)]+)\)/g, (m) => target(m[1])),
    links: all(/(?<!!)\[[^\]]*\]\(([^)\s]+)\)/g, (m) => (m[1].startsWith('#') ? '#' : target(m[1]))),
    blocks: all(/^ *```[\s\S]*?^ *```/gm, (m) => m[0]),
    code: [...withoutBlocks(text).matchAll(/`[^`]+`/g)].map((m) => m[0]),
  };
}

// What is wrong with a translation, a sentence each.
export function wrongInTranslation(root, file) {
  const name = file.slice('docs/de/'.length);
  const original = `docs/${name}`;
  const missing = kLanguages.filter((language) => !existsSync(join(root, 'docs', language, name)));
  const wrong = missing.map((language) => `there is no docs/${language}/${name}`);
  if (!existsSync(join(root, original))) return [...wrong, `there is no ${original}`];
  const [text, english] = [file, original].map((path) => readFileSync(join(root, path), 'utf8'));
  const mark = `<!-- translated from ${original}, checksum ${createHash('sha256').update(english).digest('hex').slice(0, 16)} -->`;
  if (!text.startsWith(`${mark}\n`)) wrong.push(`${original} has changed: translate the change, then let the first line be "${mark}"`);
  const [own, its] = [shapeOf(file, text), shapeOf(original, english)];
  for (const what of Object.keys(own)) {
    const [here, there] = [own, its].map((shape) => (kInAnyOrder.has(what) ? [...shape[what]].sort() : shape[what]));
    const at = Array.from({ length: Math.max(here.length, there.length) }).findIndex((_, i) => here[i] !== there[i]);
    if (at >= 0) wrong.push(`its ${what}: expected "${there[at]}" at ${at + 1}, as in ${original}, found "${here[at]}"`);
  }
  return wrong;
}
