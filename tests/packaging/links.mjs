// Links between texts lead to files, and to headings in them. links.mjs FOLDER checks every text in FOLDER, as where they are
// installed.
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { slug } from '../../packaging/site/markdown.mjs';

export const withoutBlocks = (text) => text.replace(/^ *```[\s\S]*?^ *```/gm, '');

export function links(root) {
  const anchors = new Map();
  function anchorsOf(path) {
    if (!anchors.has(path)) {
      const text = withoutBlocks(readFileSync(path, 'utf8'));
      anchors.set(path, new Set([...text.matchAll(/^#+ +(.*)$/gm)].map((m) => slug(m[1]))));
    }
    return anchors.get(path);
  }
  function brokenLinks(file) {
    const broken = [];
    for (const [, target] of withoutBlocks(readFileSync(join(root, file), 'utf8')).matchAll(/\]\(([^)\s]+)\)/g)) {
      if (/^[a-z]+:/.test(target)) continue;
      const [path, anchor] = target.split('#');
      const full = path ? join(root, dirname(file), path) : join(root, file);
      if (!existsSync(full)) broken.push(`a link to ${target}, which is not there`);
      else if (anchor && full.endsWith('.md') && !anchorsOf(full).has(anchor)) broken.push(`${path || file} has no heading #${anchor}`);
    }
    return broken;
  }
  return { slug, brokenLinks };
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const root = process.argv[2];
  const texts = readdirSync(root, { recursive: true }).filter((name) => name.endsWith('.md'));
  const broken = texts.flatMap((file) => links(root).brokenLinks(file).map((what) => `${file}: ${what}`));
  for (const line of broken) console.error(`FAILED: ${line}`);
  if (texts.length < 20) console.error(`FAILED: found only ${texts.length} texts in ${root}`);
  process.exit(broken.length > 0 || texts.length < 20 ? 1 : 0);
}
