import { numberText, spokenLanguage } from "../base/language";
import { say, sayIf } from "../base/words";

// What the built-in exercises, criteria and teeth say, in the language of the page. The server
// gives it in English, and the text itself names its message: without its numbers, which are the
// message's places in their order. So a text that a school has written or changed has no message
// and stays as it was typed. In English there are none of these messages: nothing changes.

const kNumber = /\d+(?:\.\d+)?/g;

// "Class I occlusal cavity", "Walls upright".
export function wordedTitle(title: string): string {
  return sayIf(`builtin_title.${nameOf(title)}`, numbersOf(title)) ?? title;
}

// What an exercise is called in lists: a practice exercise may have the title of the one that counts.
export function exerciseTitle({
  title,
  name = "",
  graded,
}: {
  readonly title: string | null;
  readonly name?: string;
  readonly graded: boolean;
}): string {
  const worded = wordedTitle(title ?? "") || name;
  return graded ? worded : say("exercise_list.practice_title", { title: worded });
}

// Instructions, or the comment of a criterion: sentence by sentence. Where one of them is not built
// in, none is translated.
export function wordedText(text: string): string {
  const told = sentencesOf(text).map((sentence) => sayIf(`builtin_text.${nameOf(sentence)}`, numbersOf(sentence)));
  return told.includes(undefined) ? text : told.join(spokenLanguage() === "zh" ? "" : " ");
}

export function sentencesOf(text: string): readonly string[] {
  return text.split(/(?<=\.) (?=[A-Z])/);
}

export function nameOf(text: string): string {
  return (
    text
      .replaceAll(kNumber, "n")
      .toLowerCase()
      .match(/[a-z0-9]+/g) ?? []
  ).join("_");
}

// From the name of the place, "a" for the first, to the number with as many decimals as were
// written.
export function numbersOf(text: string): Readonly<Record<string, string>> {
  return Object.fromEntries(
    (text.match(kNumber) ?? []).map((number, i) => {
      const decimals = number.split(".")[1]?.length ?? 0;
      return [String.fromCharCode(97 + i), numberText(Number(number), decimals, decimals)];
    }),
  );
}
