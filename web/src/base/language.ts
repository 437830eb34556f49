// The language that the page speaks, and how it writes numbers and dates. One for the whole page:
// app/language.ts changes it and draws the page again.

export type Language = "en" | "de" | "zh";

// As its speakers write it.
export const kLanguages: readonly { readonly code: Language; readonly name: string }[] = [
  { code: "en", name: "English" },
  { code: "de", name: "Deutsch" },
  { code: "zh", name: "中文" },
];

// Of a code (BCP 47), by its first part: "de", "de-CH". Undefined: the page has no such language.
export function languageOf(code: string): Language | undefined {
  const first = code.toLowerCase().split(/[-_]/)[0];
  return kLanguages.find((language) => language.code === first)?.code;
}

// The first of these that the page speaks: what a browser is set to.
export function firstLanguage(codes: readonly string[]): Language {
  return codes.map(languageOf).find((language) => language !== undefined) ?? "en";
}

interface Spoken {
  readonly language: Language;
  readonly locale: string; // for Intl: the browser's own where it is of this language, as en-GB has other dates
}

let now: Spoken = { language: "en", locale: "en" };
let plurals = new Intl.PluralRules("en");
// Each takes long to make, a date's as long as a screen takes to be drawn.
let numbers = new Map<number, Intl.NumberFormat>(); // by least and most decimals
let dates = new Map<boolean, Intl.DateTimeFormat>(); // with the time of day

export function speak(language: Language, browser: readonly string[] = []): void {
  const locale =
    browser.find((code) => languageOf(code) === language && isLocale(code)) ?? (language === "zh" ? "zh-CN" : language);
  now = { language, locale };
  plurals = new Intl.PluralRules(language);
  numbers = new Map();
  dates = new Map();
}

function isLocale(code: string): boolean {
  try {
    return Intl.getCanonicalLocales(code).length === 1;
  } catch {
    return false;
  }
}

export function spokenLanguage(): Language {
  return now.language;
}

export function spokenLocale(): string {
  return now.locale;
}

export function pluralOf(count: number): string {
  return plurals.select(count);
}

function numberFormat(least: number, most: number): Intl.NumberFormat {
  const key = 100 * least + most;
  const known = numbers.get(key);
  if (known !== undefined) return known;
  const made = new Intl.NumberFormat(now.language, { minimumFractionDigits: least, maximumFractionDigits: most });
  numbers.set(key, made);
  return made;
}

export function dateText(unixMs: number, withTime: boolean): string {
  let format = dates.get(withTime);
  if (format === undefined) {
    format = new Intl.DateTimeFormat(now.locale, { dateStyle: "medium", ...(withTime ? { timeStyle: "short" } : {}) });
    dates.set(withTime, format);
  }
  return format.format(new Date(unixMs));
}

// With the language's decimal sign, a true minus sign, and thin grouping of thousands (ISO
// 80000-1).
export function numberText(value: number, least: number, most: number): string {
  const text = numberFormat(least, most)
    .formatToParts(Math.abs(value))
    .map((part) => (part.type === "group" ? "\u202f" : part.value))
    .join("");
  return (value < 0 ? "−" : "") + text;
}
