// Markdown as the guides write it, as HTML: headings, paragraphs, lists in lists, tables, blocks of code, quotes; links, pictures,
// code, bold, italics. tests/packaging/site.mjs fails where a page shows Markdown that was not understood.
const escaped = (text) => text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;');

// As GitHub makes a heading's anchor.
export const slug = (heading) => heading.replace(/[`*]/g, '').trim().toLowerCase().replace(/[^\p{L}\p{N}\s_-]/gu, '').replace(/\s/g, '-');

const kItem = /^(\s*)([*-]|\d+\.)(\s+)(?=\S)/;
const kRow = /^\s*\|/;
const isTable = (lines, at) => kRow.test(lines[at] ?? '') && /^\s*\|[\s:|-]+\|\s*$/.test(lines[at + 1] ?? '');
const startsBlock = (lines, at) => /^\s*```|^#{1,6} |^> ?/.test(lines[at]) || isTable(lines, at) || kItem.test(lines[at]);

function inline(text, href) {
  const kept = [];
  const keep = (html) => `\u0001${kept.push(html) - 1}\u0002`;
  let out = text.replace(/`([^`]+)`/g, (_, code) => keep(`<code>${escaped(code)}</code>`)).replace(/\\([|*_])/g, (_, sign) => keep(sign));
  out = out.replace(/<(https?:[^>\s]+)>/g, (_, url) => keep(`<a href="${escaped(url)}">${escaped(url)}</a>`));
  out = escaped(out);
  out = out.replace(/!\[([^\]]*)\]\(([^)\s]+)\)/g, (_, alt, src) => keep(`<img src="${href(src)}" alt="${alt.replace(/"/g, '&quot;')}" loading="lazy">`));
  out = out.replace(/\[([^\]]+)\]\(([^)\s]+)\)/g, (_, of, to) => `${keep(`<a href="${href(to)}">`)}${of}${keep('</a>')}`);
  out = out.replace(/\*\*(?=\S)([\s\S]+?)(?<=\S)\*\*/g, '<strong>$1</strong>').replace(/(?<![\w*])\*(?=[^\s*])([^*]+?)(?<=[^\s*])\*(?![\w*])/g, '<em>$1</em>').replace(/(?<=\p{Script=Han}|[，。、；：（“])\*(?=[^\s*])([^*]+?)(?<=[^\s*])\*/gu, '<em>$1</em>');
  while (/\u0001\d+\u0002/.test(out)) out = out.replace(/\u0001(\d+)\u0002/g, (_, at) => kept[Number(at)]);
  return out;
}

function table(rows, href) {
  const cells = (row) => row.trim().replace(/^\||\|$/g, '').split(/(?<!\\)\|/).map((cell) => inline(cell.trim().replace(/\\\|/g, '|'), href));
  const sides = rows[1].trim().replace(/^\||\|$/g, '').split('|').map((cell) => (/-:\s*$/.test(cell) ? ' class="right"' : ''));
  const line = (row, of) => `<tr>${cells(row).map((cell, i) => `<${of}${sides[i] ?? ''}>${cell}</${of}>`).join('')}</tr>`;
  return `<div class="wide"><table><thead>${line(rows[0], 'th')}</thead><tbody>${rows.slice(2).map((row) => line(row, 'td')).join('')}</tbody></table></div>`;
}

function blocks(lines, href, ids) {
  const out = [];
  for (let i = 0; i < lines.length; ) {
    const line = lines[i];
    const heading = line.match(/^(#{1,6}) +(.*)$/);
    const item = line.match(kItem);
    if (line.trim() === '') ++i;
    else if (/^\s*```/.test(line)) {
      const end = lines.findIndex((other, at) => at > i && /^\s*```\s*$/.test(other));
      const code = lines.slice(i + 1, end);
      const indent = line.match(/^\s*/)[0].length;
      out.push(`<pre><code>${escaped(code.map((each) => each.slice(Math.min(indent, each.match(/^\s*/)[0].length))).join('\n'))}</code></pre>`);
      i = end + 1;
    } else if (heading) {
      const id = slug(heading[2]);
      const same = ids.get(id) ?? 0;
      ids.set(id, same + 1);
      out.push(`<h${heading[1].length} id="${same ? `${id}-${same}` : id}">${inline(heading[2], href)}</h${heading[1].length}>`);
      ++i;
    } else if (isTable(lines, i)) {
      let end = i;
      while (kRow.test(lines[end] ?? '')) ++end;
      out.push(table(lines.slice(i, end), href));
      i = end;
    } else if (/^> ?/.test(line)) {
      let end = i;
      while (/^> ?/.test(lines[end] ?? '')) ++end;
      out.push(`<blockquote>${blocks(lines.slice(i, end).map((each) => each.replace(/^> ?/, '')), href, ids)}</blockquote>`);
      i = end;
    } else if (item) {
      const ordered = /\d/.test(item[2]);
      const items = [];
      while (i < lines.length) {
        const next = lines[i].match(kItem);
        if (!next || next[1].length !== item[1].length || /\d/.test(next[2]) !== ordered) break;
        const own = [lines[i].slice(next[0].length)];
        for (++i; i < lines.length; ++i) {
          const indented = lines[i].match(/^\s*/)[0].length > item[1].length;
          const isLast = lines[i].trim() === '' && !(/^\s+\S/.test(lines[i + 1] ?? '') && lines[i + 1].match(/^\s*/)[0].length > item[1].length);
          if (isLast || (!indented && lines[i].trim() !== '' && startsBlock(lines, i)) || (!indented && lines[i].trim() !== '' && lines[i - 1].trim() === '')) break;
          own.push(lines[i].slice(Math.min(next[0].length, lines[i].match(/^\s*/)[0].length)));
        }
        items.push(`<li>${blocks(own, href, ids).replace(/^<p>([\s\S]*?)<\/p>/, '$1')}</li>`);
        while (lines[i]?.trim() === '' && kItem.test(lines[i + 1] ?? '')) ++i;
      }
      const first = Number.parseInt(item[2], 10);
      out.push(`<${ordered ? `ol${first > 1 ? ` start="${first}"` : ''}` : 'ul'}>${items.join('')}</${ordered ? 'ol' : 'ul'}>`);
    } else {
      let end = i + 1;
      while (end < lines.length && lines[end].trim() !== '' && !(startsBlock(lines, end) && !/^\s*\d+\. /.test(lines[end]))) ++end;
      out.push(`<p>${inline(lines.slice(i, end).map((each) => each.trim()).join('\n'), href)}</p>`);
      i = end;
    }
  }
  return out.join('\n');
}

const withoutComments = (markdown) => markdown.replace(/<!--[\s\S]*?-->\n?/g, '');

// `href` says where a link of the Markdown leads from the page.
export const htmlOf = (markdown, href) => blocks(withoutComments(markdown).split('\n'), href, new Map());

// Parts of a text, each from its heading to the next of the first three levels.
export function headingsOf(markdown) {
  const parts = [];
  let inBlock = false;
  for (const line of withoutComments(markdown).split('\n')) {
    if (/^\s*```/.test(line)) inBlock = !inBlock;
    const heading = inBlock ? null : line.match(/^#{1,3} +(.*)$/);
    if (heading) parts.push({ id: slug(heading[1]), title: textOf(heading[1]), text: '' });
    else if (parts.length > 0) parts.at(-1).text += `${line}\n`;
  }
  return parts;
}

// Without its signs.
export const textOf = (markdown) => markdown.replace(/!?\[([^\]]*)\]\([^)\s]*\)/g, '$1').replace(/^\s*```.*$/gm, '').replace(/^\|[\s:|-]+\|$/gm, '').replace(/[`*|>]/g, ' ').replace(/\s+/g, ' ').trim();
