import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { say } from "../base/words";

// Small building blocks without any state of the application.

export type Tone = "good" | "warning" | "bad" | "neutral";

const kIcons: Readonly<Record<Tone, string>> = { good: "✓", warning: "!", bad: "✕", neutral: "•" };

// A short state in words; the icon and the colour only repeat it.
export function Badge({ tone, children }: { readonly tone: Tone; readonly children: ComponentChildren }) {
  return (
    <span class={`badge ${tone}`}>
      <span aria-hidden="true">{kIcons[tone]}</span> {children}
    </span>
  );
}

export function Notice({
  tone,
  title,
  children,
}: {
  readonly tone: Tone;
  readonly title?: string;
  readonly children?: ComponentChildren;
}) {
  return (
    <div class={`notice ${tone}`} role={tone === "bad" ? "alert" : "status"}>
      <span class="notice-icon" aria-hidden="true">
        {kIcons[tone]}
      </span>
      <div>
        {title !== undefined && <p class="notice-title">{title}</p>}
        {children}
      </div>
    </div>
  );
}

// Figures that are made when somebody unfolds them.
export function Folded({ title, content }: { readonly title: string; readonly content: () => ComponentChildren }) {
  const [open, setOpen] = useState(false);
  return (
    <details class="numbers" onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{title}</summary>
      {open && content()}
    </details>
  );
}

export function ErrorNotice({
  title,
  message,
  onRetry,
}: {
  readonly title: string;
  readonly message: string;
  readonly onRetry?: (() => void) | undefined;
}) {
  return (
    <Notice tone="bad" title={title}>
      <p>{message}</p>
      {onRetry !== undefined && (
        <button type="button" class="button small" onClick={onRetry}>
          {say("common.try_again")}
        </button>
      )}
    </Notice>
  );
}

// `what`: a sentence, "Loading the list…".
export function Loading({ what }: { readonly what: string }) {
  return (
    <p class="loading" role="status">
      <span class="spinner" aria-hidden="true" />
      {what}
    </p>
  );
}

interface WaitsProps {
  readonly loaded:
    | { readonly state: "loading" | "ready" }
    | { readonly state: "failed"; readonly error: { readonly message: string } };
  readonly reload?: () => void;
  readonly what: string; // as of Loading
  readonly failed: string; // title of the notice
  readonly children?: ComponentChildren; // above the notice
}

// Instead of what is not there yet, or could not be loaded.
export function Waits({ loaded, reload, what, failed, children }: WaitsProps) {
  if (loaded.state !== "failed") return loaded.state === "loading" ? <Loading what={what} /> : null;
  return (
    <>
      {children}
      <ErrorNotice title={failed} message={loaded.error.message} onRetry={reload} />
    </>
  );
}

export function Empty({ children }: { readonly children: ComponentChildren }) {
  return <p class="empty">{children}</p>;
}

// The heading of a screen; takes the focus when the screen appears, so that a screen reader begins
// there.
export function PageTitle({
  children,
  document: documentTitle,
}: {
  readonly children: ComponentChildren;
  readonly document: string;
}) {
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    document.title = say("app.document", { title: documentTitle });
  }, [documentTitle]);
  useEffect(() => heading.current?.focus({ preventScroll: true }), []);
  return (
    <h1 tabIndex={-1} ref={heading}>
      {children}
    </h1>
  );
}

export function Card({
  title,
  aside,
  children,
  className = "",
}: {
  readonly title?: string;
  readonly aside?: ComponentChildren;
  readonly children: ComponentChildren;
  readonly className?: string;
}) {
  return (
    <section class={`card ${className}`} aria-label={title}>
      {title !== undefined && (
        <div class="card-head">
          <h2>{title}</h2>
          {aside}
        </div>
      )}
      {children}
    </section>
  );
}

// A table that scrolls sideways inside itself on a narrow screen, reachable by keyboard.
export function TableFrame({ label, children }: { readonly label: string; readonly children: ComponentChildren }) {
  return (
    <div
      class="table-frame"
      role="group"
      aria-label={label}
      // biome-ignore lint/a11y/noNoninteractiveTabindex: keys scroll it once it has the focus
      tabIndex={0}
    >
      {children}
    </div>
  );
}

// `share` 0..1. The bar repeats the number next to it and is hidden from screen readers.
export function Bar({ share, tone }: { readonly share: number; readonly tone: Tone }) {
  const percent = Math.min(Math.max(share, 0), 1) * 100;
  return (
    <span class={`bar ${tone}`} aria-hidden="true">
      <span style={{ width: `${percent}%` }} />
    </span>
  );
}

export function Progress({ label, share }: { readonly label: string; readonly share: number | undefined }) {
  const percent = share === undefined ? undefined : Math.round(Math.min(Math.max(share, 0), 1) * 100);
  return (
    <div class="progress">
      <div class="progress-head">
        <span>{label}</span>
        {percent !== undefined && <span>{percent} %</span>}
      </div>
      <progress aria-label={label} max={100} {...(percent === undefined ? {} : { value: percent })} />
    </div>
  );
}

export interface Choice<T extends string> {
  readonly value: T;
  readonly title: string;
}

// One of a few, as radio buttons in a row.
export function Segmented<T extends string>({
  legend,
  name,
  choices,
  value,
  onChange,
}: {
  readonly legend: string;
  readonly name: string;
  readonly choices: readonly Choice<T>[];
  readonly value: T;
  readonly onChange: (value: T) => void;
}) {
  return (
    <fieldset class="segmented">
      <legend class="hidden">{legend}</legend>
      {choices.map((choice) => (
        <label key={choice.value}>
          <input
            type="radio"
            name={name}
            value={choice.value}
            checked={choice.value === value}
            onChange={() => onChange(choice.value)}
          />
          <span>{choice.title}</span>
        </label>
      ))}
    </fieldset>
  );
}

// `shown` is enough for people who see its place; a screen reader reads `full`. Voice control is told what is shown, so
// the name begins with it (WCAG 2.5.3).
export function Brief({ shown, full }: { readonly shown: string; readonly full: string }) {
  return (
    <>
      {shown}
      {full !== shown && <span class="hidden">{rest(shown, full)}</span>}
    </>
  );
}

function rest(shown: string, full: string): string {
  const begun = [shown, shown.replace(/ ?…$/, "")].find((text) => full.startsWith(text));
  return begun === undefined ? `, ${full}` : full.slice(begun.length);
}
