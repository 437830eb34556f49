// What a PDF of Chromium's shows: its text in the order in which it is painted, how many pictures and pages it has, and the names
// of its fonts. Only as much of PDF (ISO 32000) as Chromium writes: no object streams, and fonts with ToUnicode, whose glyphs have
// two bytes (Type 0) or one (Type 3, as of OpenType fonts with cubic outlines).
import { inflateSync } from "node:zlib";

function objectsOf(bytes) {
  const text = bytes.toString("latin1");
  const objects = new Map();
  for (const match of text.matchAll(/(\d+) 0 obj\b([\s\S]*?)\bendobj/g)) {
    const [, id, body] = match;
    const at = body.indexOf("stream");
    const head = at < 0 ? body : body.slice(0, at);
    let stream;
    if (at >= 0) {
      const from = match.index + match[0].indexOf("stream") + (body[at + 6] === "\r" ? 8 : 7);
      const length = Number(/\/Length (\d+)/.exec(head)?.[1]);
      const raw = bytes.subarray(from, from + length);
      stream = /FlateDecode/.test(head) && !/\/Subtype \/Image/.test(head) ? inflateSync(raw).toString("latin1") : "";
    }
    objects.set(Number(id), { head, stream });
  }
  return objects;
}

// Glyphs to text.
function unicodeOf(cmap) {
  const out = new Map();
  const words = (hex) => String.fromCharCode(...hex.match(/..../g).map((word) => Number.parseInt(word, 16)));
  for (const [, block] of cmap.matchAll(/beginbfchar([\s\S]*?)endbfchar/g))
    for (const [, glyph, to] of block.matchAll(/<([0-9a-f]+)> *<([0-9a-f]+)>/gi)) out.set(Number.parseInt(glyph, 16), words(to));
  for (const [, block] of cmap.matchAll(/beginbfrange([\s\S]*?)endbfrange/g))
    for (const [, first, last, to] of block.matchAll(/<([0-9a-f]+)> *<([0-9a-f]+)> *<([0-9a-f]+)>/gi))
      for (let glyph = Number.parseInt(first, 16), i = 0; glyph <= Number.parseInt(last, 16); ++glyph, ++i)
        out.set(glyph, String.fromCharCode(Number.parseInt(to, 16) + i));
  return out;
}

export function readPdf(bytes) {
  const objects = objectsOf(bytes);
  const fonts = new Map(); // by the name that pages use
  for (const { head } of objects.values())
    for (const [, block] of head.matchAll(/\/Font <<([^>]*)>>/g))
      for (const [, name, id] of block.matchAll(/\/(\w+) (\d+) 0 R/g)) {
        const font = objects.get(Number(id)).head;
        const unicode = /\/ToUnicode (\d+) 0 R/.exec(font)?.[1];
        if (unicode === undefined) continue;
        const one = /\/Subtype \/Type3/.test(font) ? /../g : /..../g;
        fonts.set(name, { glyphs: unicodeOf(objects.get(Number(unicode)).stream), one });
      }
  const all = [...objects.values()];
  const count = (pattern) => all.filter(({ head }) => pattern.test(head)).length;
  let text = "";
  let unknown = 0; // glyphs without a meaning
  for (const { stream } of all) {
    if (stream === undefined || !/\bBT\b/.test(stream)) continue;
    let font;
    for (const [, name, shown, moved] of stream.matchAll(/\/(\w+) [\d.]+ Tf|((?:\[[^\]]*\]|<[0-9A-Fa-f]*>|\((?:\\.|[^\\)])*\)) ?TJ?j?)|\b(Tm|Td|T\*)\b/g)) {
      if (name !== undefined) font = fonts.get(name);
      else if (moved !== undefined) text += " ";
      else
        for (const [, hex] of shown.matchAll(/<([0-9A-Fa-f]*)>/g))
          for (const glyph of hex.match(font?.one ?? /..../g) ?? []) {
            const found = font?.glyphs.get(Number.parseInt(glyph, 16));
            if (found === undefined) ++unknown;
            text += found ?? "";
          }
    }
    text += "\n";
  }
  const names = new Set(all.flatMap(({ head }) => [...head.matchAll(/\/FontName \/(?:[A-Z]{6}\+)?([\w-]+)/g)].map(([, name]) => name)));
  return { text, unknown, pictures: count(/\/Subtype \/Image/), pages: count(/\/Type \/Page\b/), fonts: [...names] };
}
