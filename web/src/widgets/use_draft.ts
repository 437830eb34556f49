import { useState } from "preact/hooks";
import { draftOf, keepDraft } from "../base/drafts";

// The text of a field that keeps what is typed until `forget` is called: after it was sent, or given up. `begin` is
// what the field has where there is no draft.
export function useDraft(what: string, begin = "") {
  const [text, setText] = useState(() => draftOf(what)?.text ?? begin);
  const put = (next: string) => {
    setText(next);
    keepDraft(what, { text: next });
  };
  const forget = () => {
    setText(begin);
    keepDraft(what, { text: "" });
  };
  return [text, put, forget] as const;
}
