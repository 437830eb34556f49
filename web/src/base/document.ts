// Editing a JSON document step by step: its places, its history, and what differs between two.

export type Json = null | boolean | number | string | readonly Json[] | { readonly [name: string]: Json };
export type Path = ReadonlyArray<string | number>;

export function valueAt(document: Json, path: Path): Json | undefined {
  let here: Json | undefined = document;
  for (const step of path) {
    if (here === null || typeof here !== "object") return undefined;
    here = (here as { readonly [name: string]: Json })[step];
  }
  return here;
}

// The document with `value` at that place; undefined takes the place away. What the path leads
// through is there.
export function withValue(document: Json, path: Path, value: Json | undefined): Json {
  const [step, ...rest] = path;
  if (step === undefined) return value ?? null;
  if (Array.isArray(document)) {
    const items: Json[] = [...(document as readonly Json[])];
    if (rest.length === 0 && value === undefined) items.splice(Number(step), 1);
    else items[Number(step)] = withValue(items[Number(step)] ?? null, rest, value);
    return items;
  }
  const members: Record<string, Json> = { ...(document as { readonly [name: string]: Json } | null) };
  if (rest.length === 0 && value === undefined) delete members[String(step)];
  else members[String(step)] = withValue(members[String(step)] ?? {}, rest, value);
  return members;
}

// As the server names a place: "rubric.criteria[2].points".
export function pathText(path: Path): string {
  return path.map((step, i) => (typeof step === "number" ? `[${step}]` : i === 0 ? step : `.${step}`)).join("");
}

// The place that the server names so, or as a pointer: "/rubric/criteria/2/points" (RFC 6901).
export function pathOf(text: string): Path {
  const steps = text.startsWith("/")
    ? text
        .slice(1)
        .split("/")
        .map((step) => step.replaceAll("~1", "/").replaceAll("~0", "~"))
    : (text.match(/[^.[\]]+/g) ?? []);
  return steps.map((step) => (/^\d+$/.test(step) ? Number(step) : step));
}

export interface Change {
  readonly path: Path; // in the later document; in the earlier one for what is gone
  readonly before: Json | undefined;
  readonly after: Json | undefined;
}

// The differences, place by place, in the order of the later document. An item with a metric, or of
// a kind, is compared with the item of the same one at any place, so an inserted item changes nothing else.
// Lists of numbers, and lists of them, are one value.
export function changesBetween(before: Json | undefined, after: Json | undefined, path: Path = []): Change[] {
  if (equal(before, after)) return [];
  if (isMembers(before) && isMembers(after)) {
    const names = [...Object.keys(after), ...Object.keys(before).filter((name) => !(name in after))];
    return names.flatMap((name) => changesBetween(before[name], after[name], [...path, name]));
  }
  if (isItems(before) && isItems(after)) return itemChanges(before, after, path);
  return [{ path, before, after }];
}

function itemChanges(before: readonly Json[], after: readonly Json[], path: Path): Change[] {
  const left = new Set(before.keys());
  const out = after.flatMap((item, i) => {
    const at = [...left].find((place) => keyOf(before[place]!, place) === keyOf(item, i));
    if (at !== undefined) left.delete(at);
    return changesBetween(at === undefined ? undefined : before[at], item, [...path, i]);
  });
  return [...out, ...[...left].map((at) => ({ path: [...path, at], before: before[at], after: undefined }))];
}

function keyOf(item: Json, place: number): string {
  const named = isMembers(item) ? (item["metric"] ?? item["of"]) : undefined;
  return typeof named === "string" ? named : String(place);
}

export function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isMembers(value: Json | undefined): value is { readonly [name: string]: Json } {
  return isObject(value);
}

function isItems(value: Json | undefined): value is readonly Json[] {
  return Array.isArray(value) && value.every(isMembers);
}

export function equal(a: Json | undefined, b: Json | undefined): boolean {
  if (a === b) return true;
  if (
    typeof a !== "object" ||
    typeof b !== "object" ||
    a === null ||
    b === null ||
    Array.isArray(a) !== Array.isArray(b)
  )
    return false;
  const [left, right] = [a as { readonly [name: string]: Json }, b as { readonly [name: string]: Json }];
  const names = Object.keys(left);
  return (
    names.length === Object.keys(right).length && names.every((name) => name in right && equal(left[name], right[name]))
  );
}

// The steps of an edit. What is typed into one place one after the other is one step.
export interface History {
  readonly past: readonly Json[];
  readonly now: Json;
  readonly future: readonly Json[];
  readonly place: string; // that the last change was at; empty: the next is a step of its own
}

const kMaxSteps = 200;

export function begun(now: Json): History {
  return { past: [], now, future: [], place: "" };
}

export function changed(history: History, path: Path, value: Json | undefined): History {
  const now = withValue(history.now, path, value);
  if (equal(now, history.now)) return history;
  // A place that comes or goes is a step, however soon after the last.
  const place = value === undefined || (typeof value === "object" && value !== null) ? "" : pathText(path);
  const same = place !== "" && place === history.place;
  return { past: same ? history.past : [...history.past, history.now].slice(-kMaxSteps), now, future: [], place };
}

export function undone(history: History): History {
  const before = history.past.at(-1);
  return before === undefined
    ? history
    : { past: history.past.slice(0, -1), now: before, future: [history.now, ...history.future], place: "" };
}

export function redone(history: History): History {
  const [next, ...rest] = history.future;
  return next === undefined ? history : { past: [...history.past, history.now], now: next, future: rest, place: "" };
}
