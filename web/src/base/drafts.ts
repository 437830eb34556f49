// What somebody has typed and not sent yet. It is kept in this browser, for the person who is signed in: it outlives
// another page, a reload and an expired session. Sending it, cancelling it or signing out erases it.

export interface Draft {
  readonly text: string;
  readonly point?: readonly [number, number, number] | undefined; // of the tooth, mm
  readonly seconds?: number | undefined; // the moment of the attempt
}

type Storage = Pick<globalThis.Storage, "getItem" | "setItem" | "removeItem">;

const kMost = 100; // of one person
const kMaxText = 16_000; // a mark with a comment on every criterion

let person = "";

// Whose drafts are read and kept from now on.
export function draftsOf(id: string): void {
  person = id;
}

// `what` names the field and the thing that it is about.
export function draftOf(what: string, storage?: Storage): Draft | undefined {
  return read(storage).find(([name]) => name === what)?.[1];
}

// The newest first; the oldest of too many goes. A draft without text is none.
export function keepDraft(what: string, draft: Draft, storage?: Storage): void {
  const others = read(storage).filter(([name]) => name !== what);
  const kept = draft.text.trim() === "" ? others : [[what, draft] as const, ...others].slice(0, kMost);
  try {
    const place = storage ?? localStorage;
    if (kept.length === 0) place.removeItem(keyOf());
    else place.setItem(keyOf(), JSON.stringify(kept));
  } catch {
    // A browser that keeps nothing has no drafts.
  }
}

export function eraseDrafts(storage?: Storage): void {
  try {
    (storage ?? localStorage).removeItem(keyOf());
  } catch {
    // There is nothing to erase.
  }
}

type Kept = readonly (readonly [string, Draft])[];

function read(storage: Storage | undefined): Kept {
  try {
    const found: unknown = JSON.parse((storage ?? localStorage).getItem(keyOf()) ?? "[]");
    return Array.isArray(found) ? found.filter(isKept) : [];
  } catch {
    return [];
  }
}

function isKept(found: unknown): found is Kept[number] {
  if (!Array.isArray(found) || typeof found[0] !== "string") return false;
  const { text, point, seconds } = (found[1] ?? {}) as Partial<Draft>;
  return (
    typeof text === "string" &&
    text.length <= kMaxText &&
    (point === undefined || (Array.isArray(point) && point.length === 3 && point.every(Number.isFinite))) &&
    (seconds === undefined || Number.isFinite(seconds))
  );
}

function keyOf(): string {
  return `enamel.drafts.${person}`;
}
