import { signal } from "@preact/signals";
import type { Session } from "../api/types";
import { firstLanguage, languageOf, spokenLanguage, type Language } from "../base/language";
import { changeLanguage, type loadWords } from "../base/words";

// Which language the page speaks: the one that the person chose, else the one chosen in this
// browser before signing in, else the first that the browser is set to and that the page has.
export const language = signal<Language>("en");

const kKey = "enamel.language";
let begun = false; // there are words

function kept(): Language | undefined {
  try {
    return languageOf(localStorage.getItem(kKey) ?? "");
  } catch {
    return undefined; // a browser that keeps nothing
  }
}

// `choice`: of a person; empty: none. False where its words could not be loaded: the page continues
// in the one it has.
// `soon`: the parts whose words are wanted next.
export async function applyLanguage(
  choice: Session["language"],
  soon: Parameters<typeof loadWords>[0][] = [],
): Promise<boolean> {
  const next = choice === "" ? (kept() ?? firstLanguage(navigator.languages)) : choice;
  try {
    if (!begun || next !== spokenLanguage()) await changeLanguage(next, navigator.languages, soon);
    begun = true;
  } catch {
    return false;
  }
  document.documentElement.lang = next === "zh" ? "zh-Hans" : next;
  language.value = next;
  return true;
}

// Somebody chose it in this browser before signing in.
export function keepLanguage(choice: Language): void {
  try {
    localStorage.setItem(kKey, choice);
  } catch {
    // Then it is asked again the next time.
  }
}
