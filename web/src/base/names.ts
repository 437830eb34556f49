import { spokenLocale } from "./language";

// Whether a name has every word that was typed, whatever the case and accents.
export function nameHas(name: string, text: string): boolean {
  const has = plain(name);
  return plain(text)
    .split(/\s+/)
    .every((word) => has.includes(word));
}

export function compareNames(a: string, b: string): number {
  return a.localeCompare(b, spokenLocale(), { numeric: true });
}

function plain(text: string): string {
  return text.normalize("NFKD").replace(/\p{M}/gu, "").toLowerCase();
}
