import { useState } from "preact/hooks";

// Text that is typed elsewhere, with a button that copies it. Where the browser does not allow
// copying (a page without TLS), the text is selected instead, so that Ctrl+C does it.
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
      <button type="button" class="button small" onClick={(event) => void copy(event.currentTarget)}>Copy<span class="hidden"> {what}</span></button>
      <span class="hint" role="status">{state === "copied" ? "Copied" : state === "selected" ? "Selected: press Ctrl+C" : ""}</span>
    </div>
  );
}
