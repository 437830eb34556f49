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

interface Named {
  readonly login: string;
  readonly display_name: string;
}

// How a list names each of `people`: two of one name by their logins, too.
export function namesIn(people: readonly Named[]): (person: Named) => string {
  const logins = new Map<string, string>();
  const shared = new Set<string>();
  for (const { display_name: name, login } of people) {
    if ((logins.get(name) ?? login) !== login) shared.add(name);
    logins.set(name, login);
  }
  return ({ display_name: name, login }) => (shared.has(name) ? `${name} (${login})` : name);
}
