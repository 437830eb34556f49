// Few combinations of which every pair of values is in one: of pages, widths, languages and themes.

// `factors`: {name: values}. `fits(combination)`: whether there can be such a one.
export function allOf(factors, fits = () => true) {
  const whole = Object.entries(factors).reduce(
    (some, [name, values]) => some.flatMap((one) => values.map((value) => ({ ...one, [name]: value }))),
    [{}],
  );
  return whole.filter(fits);
}

const pairsOf = (combination) => {
  const entries = Object.entries(combination);
  return entries.flatMap(([a, x], i) => entries.slice(i + 1).map(([b, y]) => `${a}=${x} ${b}=${y}`));
};

// `each` combinations for every page. Chosen one after the other: first the page's own values that it has not met, then
// the pairs that are in the fewest so far; the first of equals, so that every run chooses the same.
export function covering(pages, factors, { each, fits } = {}) {
  const looks = allOf(factors, fits);
  const uses = new Map(looks.flatMap((look) => pairsOf(look)).map((pair) => [pair, 0]));
  const out = [];
  for (const page of pages) {
    const met = new Set();
    const valuesOf = (look) => Object.entries(look).map(([name, value]) => `${name}=${value}`);
    const rarity = (look) => pairsOf(look).reduce((sum, pair) => sum + 1 / (1 + uses.get(pair)) ** 2, 0);
    // A value weighs more than all pairs together.
    const worth = (look) => 100 * valuesOf(look).filter((value) => !met.has(value)).length + rarity(look);
    for (let i = 0; i < each; ++i) {
      const best = looks.reduce((most, look) => (worth(look) > worth(most) ? look : most));
      for (const value of valuesOf(best)) met.add(value);
      for (const pair of pairsOf(best)) uses.set(pair, uses.get(pair) + 1);
      out.push({ page, ...best });
    }
  }
  return { combinations: out, left: [...uses].filter(([, count]) => count === 0).map(([pair]) => pair) };
}
