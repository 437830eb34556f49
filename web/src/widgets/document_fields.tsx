import type { ApiError } from "../api/http";
import { plainMessage } from "../api/placed";
import type { Checked } from "../api/use_check";
import { equal, type Json, type Path, pathOf, pathText, valueAt } from "../base/document";
import { formatNumber } from "../base/format";
import { say, sayIf } from "../base/words";
import { CheckField, LongTextField, NumberField, type Option, SelectField, TextField } from "./form";
import type { EditedDocument } from "./use_document";

// Fields of a document that is edited, each for one place in it. What the server found wrong is
// shown at its place.

export interface DocumentForm {
  readonly edit: EditedDocument;
  readonly wrong?: { readonly field: string; readonly message: string } | undefined;
  readonly own?: ReadonlyMap<string, string>; // what the page itself sees to be wrong, by place; said before the server's
}

interface PlaceProps {
  readonly form: DocumentForm;
  readonly path: Path;
  readonly label: string;
  readonly hint?: string;
}

export function problemAt({ wrong, own }: DocumentForm, path: Path): string | undefined {
  const here = pathText(path);
  const seen = own?.get(here);
  if (seen !== undefined || wrong === undefined || pathText(pathOf(wrong.field)) !== here) return seen;
  // Of a list the server says what the page says of the item.
  return [...(own?.keys() ?? [])].some((place) => place.startsWith(here)) ? undefined : plainMessage(wrong);
}

// The server's problem, until the value at its place changes.
export function stillWrong({ busy, error, text }: Checked<unknown>, now: Json): ApiError | undefined {
  if (!busy || error === undefined || text === undefined) return error;
  const place = pathOf(error.field);
  return equal(valueAt(JSON.parse(text) as Json, place), valueAt(now, place)) ? error : undefined;
}

// `optional`: an empty field takes the place away.
export function DocumentText({
  form,
  path,
  label,
  hint,
  maxLength,
  long = false,
  optional = false,
}: PlaceProps & { readonly maxLength: number; readonly long?: boolean; readonly optional?: boolean }) {
  const value = form.edit.at(path);
  const common = {
    label,
    hint,
    maxLength,
    problem: problemAt(form, path),
    value: typeof value === "string" ? value : "",
    onValue: (text: string) => form.edit.set(path, optional && text === "" ? undefined : text),
  };
  return long ? <LongTextField {...common} rows={3} /> : <TextField {...common} />;
}

// `scale`: how many of the document's units are one of the field's, 1000 for millimetres of
// micrometres. `optional`: an empty field takes the place away; what else is no number stays as
// null, so that nothing is saved in its place.
export function DocumentNumber({
  form,
  path,
  label,
  hint,
  scale = 1,
  optional = false,
  whole = false,
  min,
}: PlaceProps & {
  readonly scale?: number;
  readonly optional?: boolean;
  readonly whole?: boolean;
  readonly min?: number;
}) {
  const value = form.edit.at(path);
  const set = (typed: number, unread: boolean) => {
    const exact = scale < 1 ? typed / (1 / scale) : typed * scale;
    if (Number.isFinite(typed)) form.edit.set(path, whole || scale > 1 ? Math.round(exact) : exact);
    else form.edit.set(path, optional && !unread ? undefined : null);
  };
  return (
    <NumberField
      label={label}
      hint={hint}
      problem={value === null ? (form.own?.get(pathText(path)) ?? say("editor.a_number")) : problemAt(form, path)}
      value={typeof value === "number" ? shown(value / scale) : Number.NaN}
      onValue={set}
      step="any"
      required={!optional}
      {...(min === undefined ? {} : { min })}
    />
  );
}

// A third or a sixth in six digits. The document keeps them all until somebody types.
function shown(value: number): number {
  return Number(value.toPrecision(Number.isInteger(value) ? 12 : 6));
}

export function DocumentChoice({
  form,
  path,
  label,
  hint,
  options,
}: PlaceProps & { readonly options: readonly Option[] }) {
  const value = form.edit.at(path);
  return (
    <SelectField
      label={label}
      hint={hint}
      problem={problemAt(form, path)}
      value={typeof value === "string" ? value : ""}
      options={options}
      onValue={(chosen) => form.edit.set(path, chosen)}
    />
  );
}

export function DocumentFlag({ form, path, label, hint }: PlaceProps) {
  return (
    <CheckField
      label={label}
      {...(hint === undefined ? {} : { hint })}
      value={form.edit.at(path) === true}
      onValue={(on) => form.edit.set(path, on)}
    />
  );
}

// What a value is in a table of changes.
export function shownValue(value: Json | undefined): string {
  if (value === undefined || value === null) return "–";
  if (typeof value === "string") return value === "" ? say("common.empty") : value;
  if (typeof value === "boolean") return value ? say("common.yes") : say("common.no");
  if (Array.isArray(value) && value.every((row) => Array.isArray(row) && row.length === 2))
    return value
      .map((row) => `${String((row as readonly Json[])[0])} → ${percent((row as readonly Json[])[1])}`)
      .join(", ");
  if (typeof value === "object" && "title" in value && typeof value.title === "string") return value.title;
  if (typeof value === "object" && "of" in value && typeof value.of === "string")
    return sayIf(`price_kind.${value.of}`) ?? value.of;
  return JSON.stringify(value);
}

function percent(share: Json | undefined): string {
  return typeof share === "number" ? `${formatNumber(100 * share, 1)}\u00a0%` : "–";
}
