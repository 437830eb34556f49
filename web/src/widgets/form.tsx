import type { ComponentChildren } from "preact";
import { useId } from "preact/hooks";
import { formatNumber } from "../base/format";
import { say } from "../base/words";
import { fromLocalInput, toLocalInput } from "../base/local_time";

// Fields of a form: a label, a hint, and the problem that the server found.

interface FieldProps {
  readonly label: string;
  readonly hint?: ComponentChildren;
  readonly problem?: string | undefined; // shown below and tied to the field
}

type Described = { readonly id: string; readonly "aria-describedby"?: string; readonly "aria-invalid"?: boolean };

function Field({
  label,
  hint,
  problem,
  children,
}: FieldProps & { readonly children: (attributes: Described) => ComponentChildren }) {
  const id = useId();
  const described = [hint === undefined ? "" : `${id}h`, problem === undefined ? "" : `${id}p`]
    .filter((part) => part !== "")
    .join(" ");
  return (
    <div class="field">
      <label for={id}>{label}</label>
      {children({
        id,
        ...(described === "" ? {} : { "aria-describedby": described }),
        ...(problem === undefined ? {} : { "aria-invalid": true }),
      })}
      {hint !== undefined && (
        <p class="hint" id={`${id}h`}>
          {hint}
        </p>
      )}
      {problem !== undefined && (
        <p class="field-problem" id={`${id}p`}>
          <span aria-hidden="true">✕ </span>
          {problem}
        </p>
      )}
    </div>
  );
}

interface TextProps extends FieldProps {
  readonly value: string;
  readonly onValue: (value: string) => void;
  readonly secret?: boolean;
  readonly required?: boolean;
  readonly maxLength?: number;
  readonly minLength?: number;
  readonly autocomplete?: "off" | "name" | "username" | "current-password" | "new-password";
}

export function TextField({
  label,
  hint,
  problem,
  value,
  onValue,
  secret = false,
  autocomplete = "off",
  ...rest
}: TextProps) {
  return (
    <Field label={label} hint={hint} problem={problem}>
      {(attributes) => (
        <input
          {...(secret ? { type: "password" as const } : { type: "text" as const })}
          value={value}
          autocomplete={autocomplete}
          onInput={(event) => onValue(event.currentTarget.value)}
          {...rest}
          {...attributes}
        />
      )}
    </Field>
  );
}

// In a text Enter makes a line: Ctrl+Enter sends the form, and Esc leaves the field, where a dialog does not close.
function sendOrLeave(event: KeyboardEvent & { readonly currentTarget: HTMLTextAreaElement }): void {
  const text = event.currentTarget;
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) {
    event.preventDefault();
    text.form?.querySelector<HTMLButtonElement>("[type=submit]")?.click();
  } else if (event.key === "Escape" && text.closest("dialog") === null) text.blur();
}

const kNearlyFull = 0.9; // of the characters; from then on the rest is counted

// The browser cuts off what does not fit, also of pasted text, and says nothing.
function RoomLeft({ length, most }: { readonly length: number; readonly most: number }) {
  if (length < kNearlyFull * most) return null;
  return (
    <p class="hint" role="status">
      {length < most ? say("form.left", { count: most - length }) : say("form.cut", { most: formatNumber(most, 0) })}
    </p>
  );
}

export function LongTextField({
  label,
  hint,
  problem,
  value,
  onValue,
  required = false,
  maxLength,
  rows = 4,
}: FieldProps & {
  readonly value: string;
  readonly onValue: (value: string) => void;
  readonly required?: boolean;
  readonly maxLength: number;
  readonly rows?: number;
}) {
  return (
    <Field label={label} hint={hint} problem={problem}>
      {(attributes) => (
        <>
          <textarea
            rows={rows}
            value={value}
            required={required}
            maxLength={maxLength}
            onInput={(event) => onValue(event.currentTarget.value)}
            onKeyDown={sendOrLeave}
            {...attributes}
          />
          <RoomLeft length={value.length} most={maxLength} />
        </>
      )}
    </Field>
  );
}

export interface Option<T extends string = string> {
  readonly value: T;
  readonly title: string;
}

export function SelectField<T extends string>({
  label,
  hint,
  problem,
  value,
  options,
  onValue,
}: FieldProps & { readonly value: T; readonly options: readonly Option<T>[]; readonly onValue: (value: T) => void }) {
  return (
    <Field label={label} hint={hint} problem={problem}>
      {(attributes) => (
        <select value={value} onChange={(event) => onValue(event.currentTarget.value as T)} {...attributes}>
          {options.map((option) => (
            <option key={option.value} value={option.value}>
              {option.title}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

// Whole or decimal; NaN while the text is no number. `unread`: there is text that cannot be read as
// one, such as 1e999.
export function NumberField({
  label,
  hint,
  problem,
  value,
  onValue,
  min,
  max,
  step = 1,
  required = true,
}: FieldProps & {
  readonly value: number;
  readonly onValue: (value: number, unread: boolean) => void;
  readonly min?: number;
  readonly max?: number;
  readonly step?: number | "any";
  readonly required?: boolean;
}) {
  return (
    <Field label={label} hint={hint} problem={problem}>
      {(attributes) => (
        <input
          type="number"
          value={Number.isFinite(value) ? value : ""}
          min={min}
          max={max}
          step={step}
          required={required}
          onInput={(event) => onValue(event.currentTarget.valueAsNumber, event.currentTarget.validity.badInput)}
          {...attributes}
        />
      )}
    </Field>
  );
}

// A moment in the browser's time zone; 0 for none.
export function TimeField({
  label,
  hint,
  problem,
  value,
  onValue,
  required = false,
}: FieldProps & { readonly value: number; readonly onValue: (unixMs: number) => void; readonly required?: boolean }) {
  return (
    <Field label={label} hint={hint} problem={problem}>
      {(attributes) => (
        <input
          type="datetime-local"
          value={toLocalInput(value)}
          required={required}
          onChange={(event) => onValue(fromLocalInput(event.currentTarget.value) ?? 0)}
          {...attributes}
        />
      )}
    </Field>
  );
}

export function FileField({
  label,
  hint,
  problem,
  accept,
  onFile,
}: FieldProps & { readonly accept: string; readonly onFile: (file: File | undefined) => void }) {
  return (
    <Field label={label} hint={hint} problem={problem}>
      {(attributes) => (
        <input
          type="file"
          accept={accept}
          onChange={(event) => onFile(event.currentTarget.files?.[0])}
          {...attributes}
        />
      )}
    </Field>
  );
}

export function CheckField({
  label,
  hint,
  value,
  onValue,
}: {
  readonly label: string;
  readonly hint?: string;
  readonly value: boolean;
  readonly onValue: (value: boolean) => void;
}) {
  const id = useId();
  return (
    <div class="field check">
      <input
        type="checkbox"
        id={id}
        checked={value}
        onChange={(event) => onValue(event.currentTarget.checked)}
        {...(hint === undefined ? {} : { "aria-describedby": `${id}h` })}
      />
      <div>
        <label for={id}>{label}</label>
        {hint !== undefined && (
          <p class="hint" id={`${id}h`}>
            {hint}
          </p>
        )}
      </div>
    </div>
  );
}
