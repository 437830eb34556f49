import { kAtOnce, kParts, type Cases, type Message, type Messages, type Part, type Places } from "enamel:words";
import { numberText, pluralOf, speak, spokenLanguage, type Language } from "./language";

// What people read, from the catalogues in schemas/words (schemas/words.md). The build compiles
// their messages to texts with places, and puts those that a part of the page needs into a file of
// its own for each language.

export type Key = keyof Places;
type Value = string | number;
type ValuesOf<K extends Key, Filling> = {
  readonly [Name in keyof Places[K]]: Places[K][Name] extends number ? number : Value | Filling;
};
type Rest<K extends Key, Filling> = keyof Places[K] extends never ? [] : [ValuesOf<K, Filling>];

let messages: Messages = kAtOnce;
const loaded = new Set<Part>();

// The words of a part, in the language that is spoken. Fails as loading a file does.
export async function loadWords(part: Part): Promise<void> {
  if (loaded.has(part)) return;
  const found = await kParts[spokenLanguage()][part]();
  messages = { ...messages, ...found.default };
  loaded.add(part);
}

// From now on in another language, with all parts that are there already and those that are wanted `soon`. Nothing
// changes where one cannot be loaded.
export async function changeLanguage(
  language: Language,
  browser: readonly string[],
  soon: readonly Part[] = [],
): Promise<void> {
  const parts = new Set<Part>(["first", ...loaded, ...soon]);
  const found = await Promise.all([...parts].map((part) => kParts[language][part]()));
  messages = Object.assign({}, ...found.map((words) => words.default)) as Messages;
  for (const part of parts) loaded.add(part);
  speak(language, browser);
}

// The message of this key, its places filled. Numbers decide on plurals and are written as the
// language does.
export function say<K extends Key>(key: K, ...values: Rest<K, never>): string {
  return filled(key, values[0] ?? {}).join("");
}

// A message that has elements in its places: a link, a field, something in bold.
export function sayWith<K extends Key, Filling>(key: K, values: ValuesOf<K, Filling>): (string | Filling)[] {
  return filled<Filling>(key, values);
}

// Of a key made from a code of the server: undefined where there is no such message.
export function sayIf(key: string, values: Readonly<Record<string, Value>> = {}): string | undefined {
  return Object.hasOwn(messages, key) ? filled(key, values).join("") : undefined;
}

export function sayIfWith<Filling>(
  key: string,
  values: Readonly<Record<string, Value | Filling>>,
): (string | Filling)[] | undefined {
  return Object.hasOwn(messages, key) ? filled(key, values) : undefined;
}

function filled<Filling>(key: string, values: Readonly<Record<string, Value | Filling>>): (string | Filling)[] {
  const message = Object.hasOwn(messages, key) ? messages[key] : undefined;
  return message === undefined ? [key] : partsOf(message, values);
}

function partsOf<Filling>(message: Message, values: Readonly<Record<string, Value | Filling>>): (string | Filling)[] {
  if (typeof message === "string") return textParts(message, values);
  return message.flatMap((piece) =>
    typeof piece === "string" ? textParts(piece, values) : partsOf(chosen(piece[1], values[piece[0]]), values),
  );
}

function chosen(cases: Cases, count: unknown): Message {
  const number = typeof count === "number" ? count : Number.NaN;
  return cases[`=${number}`] ?? cases[pluralOf(number)] ?? cases["other"] ?? "";
}

function textParts<Filling>(text: string, values: Readonly<Record<string, Value | Filling>>): (string | Filling)[] {
  // Every second piece is the name of a place.
  return text.split(/\{(\w+)\}/).flatMap((piece, i) => {
    if (i % 2 === 0) return piece === "" ? [] : [piece];
    const value = values[piece];
    return value === undefined ? [`{${piece}}`] : [typeof value === "number" ? numberText(value, 0, 3) : value];
  });
}
