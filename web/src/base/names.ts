import { spokenLocale } from "./language";

// Whether a name has every word that was typed, whatever the case and accents.
export function nameHas(name: string, text: string): boolean {
  const has = plain(name);
  return plain(text)
    .split(/\s+/)
    .every((word) => has.includes(word));
}

let collator: Intl.Collator | undefined;
let collatorOf = "";

export function compareNames(a: string, b: string): number {
  const locale = spokenLocale();
  // Kept: localeCompare looks the rules up for every two names.
  if (collator === undefined || collatorOf !== locale) {
    collator = new Intl.Collator(locale, { numeric: true });
    collatorOf = locale;
  }
  return collator.compare(a, b);
}

function plain(text: string): string {
  return text.normalize("NFKD").replace(/\p{M}/gu, "").toLowerCase();
}
