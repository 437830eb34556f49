// Finds sections of the guides, in the browser: index.js has them. Each word of a question must be in a section, or begin a word of it.
(() => {
  // Latin words in lower case without accents, each whole and in its parts; Chinese in pairs of characters.
  function words(text) {
    const plain = text.normalize('NFKD').replace(/\p{M}/gu, '').toLowerCase();
    const latin = plain.match(/[\p{L}\p{N}]+(?:[_.-][\p{L}\p{N}]+)*/gu) ?? [];
    const out = [];
    for (const word of latin) {
      if (/\p{Script=Han}/u.test(word)) {
        const signs = [...word].filter((sign) => /\p{Script=Han}/u.test(sign));
        for (let i = 0; i < Math.max(1, signs.length - 1); ++i) out.push(signs.slice(i, i + 2).join(''));
      } else {
        out.push(word, ...(/[_.-]/.test(word) ? word.split(/[_.-]/).filter(Boolean) : []));
      }
    }
    return out;
  }
  // The best sections for a question, the best first. A word in a heading counts more, and so does a rare one.
  function find(index, question, language) {
    const asked = [...new Set(words(question))];
    if (asked.length === 0) return [];
    const all = Object.keys(index.words);
    let scores;
    for (const word of asked) {
      const now = new Map();
      for (const known of all) {
        if (known !== word && !(word.length > 2 && known.startsWith(word))) continue;
        const sections = index.words[known];
        const worth = Math.log(1 + index.sections.length / sections.length) * (known === word ? 1 : 0.5);
        for (const number of sections) {
          const [, , title, heading] = index.sections[number];
          const inHeading = words(heading).some((each) => each.startsWith(word)) ? 4 : 1;
          const inTitle = words(title).some((each) => each.startsWith(word)) ? 2 : 1;
          now.set(number, Math.max(now.get(number) ?? 0, worth * inHeading * inTitle));
        }
      }
      scores = scores === undefined ? now : new Map([...scores].filter(([number]) => now.has(number)).map(([number, score]) => [number, score + now.get(number)]));
    }
    const ranked = [...scores].map(([number, score]) => ({
      section: index.sections[number],
      score: score * (/^docs\//.test(index.sections[number][0]) ? 2 : 1) * (index.sections[number][5] === language ? 2 : 1),
    }));
    return ranked.sort((a, b) => b.score - a.score).map(({ section }) => section);
  }
  globalThis.enamelSearch = { words, find };
  if (typeof document === 'undefined') return;

  const field = document.getElementById('search');
  const found = document.getElementById('found');
  const up = document.body.dataset.up;
  field.addEventListener('input', () => {
    const hits = find(globalThis.enamelIndex, field.value, document.documentElement.lang).slice(0, 20);
    found.hidden = field.value.trim() === '';
    const list = document.createElement('ol');
    for (const [page, id, title, heading, text] of hits) {
      const link = document.createElement('a');
      link.href = `${up}/${page}#${id}`;
      link.textContent = heading === title ? title : `${title}: ${heading}`;
      const about = document.createElement('p');
      about.textContent = text;
      const item = document.createElement('li');
      item.append(link, about);
      list.append(item);
    }
    found.replaceChildren(hits.length > 0 ? list : 'Nothing has all of these words. Try fewer.');
  });
  found.addEventListener('click', (event) => {
    if (event.target instanceof HTMLAnchorElement) found.hidden = true;
  });
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') {
      field.value = '';
      found.hidden = true;
    } else if (event.key === '/' && document.activeElement !== field) {
      event.preventDefault();
      field.focus();
    }
  });
})();
