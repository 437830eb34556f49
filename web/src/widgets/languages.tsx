import { kLanguages, type Language, spokenLanguage } from "../base/language";
import { say } from "../base/words";

// What chooses a language before anybody has signed in.
export function Languages({ onLanguage }: { readonly onLanguage: (language: Language) => void }) {
  return (
    <nav class="languages" aria-label={say("page_sign_in.language")}>
      {kLanguages.map(({ code, name }) => (
        <button
          key={code}
          type="button"
          class="button quiet small"
          lang={code}
          aria-pressed={code === spokenLanguage()}
          onClick={() => onLanguage(code)}
        >
          {name}
        </button>
      ))}
    </nav>
  );
}
