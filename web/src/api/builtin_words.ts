import { numberText, spokenLanguage } from "../base/language";
import { sayIf } from "../base/words";

// What the built-in exercises, criteria and teeth say, in the language of the page. The server gives it in English, and the
// text itself names its message: without its numbers, which are the message's places in their order. So what a school has
// written, or written anew, has no message and stays as it was typed.

const kNumber = /\d+(?:\.\d+)?/g;
const kPlaces = ["a", "b", "c", "d", "e"];

// "Class I occlusal cavity", "Walls upright".
export function wordedTitle(title: string): string {
  if (spokenLanguage() === "en") return title;
  return sayIf(`builtin_title.${nameOf(title)}`, numbersOf(title)) ?? title;
}

// Instructions, or the comment of a criterion: sentence by sentence. Where one of them is not built in, none is translated.
export function wordedText(text: string): string {
  if (spokenLanguage() === "en") return text;
  const told = sentencesOf(text).map((sentence) => sayIf(`builtin_text.${nameOf(sentence)}`, numbersOf(sentence)));
  return told.includes(undefined) ? text : told.join(spokenLanguage() === "zh" ? "" : " ");
}

export function sentencesOf(text: string): readonly string[] {
  return text.split(/(?<=\.) (?=\p{Lu})/u);
}

export function nameOf(text: string): string {
  return text.replaceAll(kNumber, "n").toLowerCase().replaceAll(/[^a-z0-9]+/g, "_").replaceAll(/^_|_$/g, "");
}

// As many decimals as were written.
export function numbersOf(text: string): Readonly<Record<string, string>> {
  const found = text.match(kNumber) ?? [];
  return Object.fromEntries(kPlaces.slice(0, found.length).map((place, i) => [place, decimal(found[i] ?? "")]));
}

function decimal(number: string): string {
  const decimals = number.split(".")[1]?.length ?? 0;
  return numberText(Number(number), decimals, decimals);
}
