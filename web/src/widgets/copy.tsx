import { useState } from "preact/hooks";
import { say } from "../base/words";

// Text that is typed elsewhere, with a button that copies it. Where the browser does not allow
// copying (a page without TLS), the text is selected instead, so that Ctrl+C does it.
// `what`: what the button does, "Copy the code".
export function CopyText({ text, what }: { readonly text: string; readonly what: string }) {
  const [state, setState] = useState<"idle" | "copied" | "selected">("idle");
  const copy = async (button: HTMLElement) => {
    try {
      await navigator.clipboard.writeText(text);
      setState("copied");
    } catch {
      const code = button.previousElementSibling;
      if (code !== null) getSelection()?.selectAllChildren(code);
      setState("selected");
    }
  };
  return (
    <div class="copy">
      <code class="copy-text">{text}</code>
      <button
        type="button"
        class="button small"
        title={what}
        aria-label={what}
        onClick={(event) => void copy(event.currentTarget)}
      >
        {say("copy.copy")}
      </button>
      <span class="hint" role="status">
        {state === "copied" ? say("copy.copied") : state === "selected" ? say("copy.selected") : ""}
      </span>
    </div>
  );
}
