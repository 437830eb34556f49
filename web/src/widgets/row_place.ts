import type { ComponentChildren, RefObject } from "preact";

// Shorter tables are in the page as a whole: the browser finds and prints all of it.
export const kWhole = 60;

export interface RowsHandle {
  readonly focus: (index: number) => void; // on the row's first link, wherever it is
}

export interface RowsProps {
  readonly keys: readonly string[]; // of the rows, in their order
  // With `place` in its <tr>.
  readonly row: (index: number, place: RowPlace) => ComponentChildren;
  readonly handle?: RefObject<RowsHandle | null>;
}

export interface RowPlace {
  readonly "data-index": number;
  readonly "aria-rowindex"?: number; // the head is the first
}

export function focusRow(body: HTMLElement | null, index: number): boolean {
  const link = body?.querySelector<HTMLElement>(`tr[data-index="${index}"] a`);
  link?.focus();
  return link != null;
}
