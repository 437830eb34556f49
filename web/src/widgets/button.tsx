import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import { say } from "../base/words";

interface ButtonProps {
  readonly children: ComponentChildren;
  readonly kind?: string; // the classes beside "button"
  readonly busy?: boolean;
  readonly blocked: string | undefined; // why it cannot be pressed now
  readonly tip?: string; // of a button in a row of small ones: the reason takes the place of its tooltip
  readonly onClick?: () => void; // none: it sends its form
  readonly [aria: `aria-${string}`]: string | boolean;
}

// A button that can be grey for a reason, and shows the reason beside it. It stays in the tab order,
// so that a screen reader comes to it and reads the reason.
export function Button({ children, kind = "primary", busy, blocked, tip, onClick, ...aria }: ButtonProps) {
  const id = useId();
  return (
    <>
      <button
        type={onClick === undefined ? "submit" : "button"}
        class={`button ${kind}`}
        disabled={busy === true}
        aria-disabled={blocked !== undefined}
        {...(tip === undefined ? { "aria-describedby": id } : { title: blocked ?? tip })}
        {...aria}
        onClick={blocked === undefined ? onClick : (event) => event.preventDefault()}
      >
        {children}
      </button>
      {tip === undefined && (
        <span class="hint" id={id}>
          {blocked}
        </span>
      )}
    </>
  );
}

// What a form still waits for, in the words of its labels; undefined once every value is there.
export function needed(values: { readonly [label: string]: unknown }): string | undefined {
  const missing = Object.keys(values).filter((label) => !values[label]);
  return missing.length === 0 ? undefined : say("common.needed", { what: missing.join(", ") });
}
