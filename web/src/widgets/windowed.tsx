import { observeWindowOffset, observeWindowRect, Virtualizer, windowScroll } from "@tanstack/virtual-core";
import { Fragment, type RefObject } from "preact";
import { useImperativeHandle, useLayoutEffect, useReducer, useRef, useState } from "preact/hooks";
import { focusRow, type RowsProps } from "./row_place";

// The rows of a long table that lie in the window and around it. Loaded with the first long table (rows.tsx).

const kAround = 12; // rows beyond the window's edges
const kRowPx = 37; // until rows have been measured

interface Windowed {
  readonly rows: ReadonlyArray<{ readonly index: number; readonly abovePx: number }>; // room of what is left out before it
  readonly belowPx: number;
  readonly bring: (index: number) => void; // into the window
}

export function ManyRows({ keys, row, handle }: RowsProps) {
  const body = useRef<HTMLTableSectionElement>(null);
  const [kept, setKept] = useState<string>();
  const wanted = useRef<number>(undefined);
  const keptAt = kept === undefined ? -1 : keys.indexOf(kept);
  const { rows, belowPx, bring } = useWindowed(keys, body, keptAt < 0 ? undefined : keptAt);
  useLayoutEffect(() => {
    if (wanted.current === undefined || !focusRow(body.current, wanted.current)) return;
    wanted.current = undefined;
  });
  useImperativeHandle(
    handle ?? null,
    () => ({
      focus: (index) => {
        if (focusRow(body.current, index)) return;
        wanted.current = index;
        bring(index);
      },
    }),
    [bring],
  );
  const rowOf = (target: EventTarget | null) =>
    target instanceof Element ? target.closest<HTMLElement>("tr[data-index]")?.dataset["index"] : undefined;
  return (
    <tbody
      ref={body}
      role="rowgroup"
      onFocusIn={({ target }) => {
        const index = rowOf(target);
        if (index !== undefined) setKept(keys[Number(index)]);
      }}
    >
      {rows.map(({ index, abovePx }) => (
        <Fragment key={keys[index]}>
          {abovePx > 0 && <Gap px={abovePx} />}
          {row(index, { "data-index": index, "aria-rowindex": index + 2 })}
        </Fragment>
      ))}
      {belowPx > 0 && <Gap px={belowPx} />}
    </tbody>
  );
}

function Gap({ px }: { readonly px: number }) {
  return (
    // biome-ignore lint/a11y/noAriaHiddenOnFocusable: a row takes no focus
    <tr class="gap" aria-hidden="true">
      <td style={{ height: `${px}px` }} />
    </tr>
  );
}

// `kept`: a row that stays in the page wherever the window is, because it has the focus.
function useWindowed(
  keys: readonly string[],
  body: RefObject<HTMLTableSectionElement | null>,
  kept: number | undefined,
): Windowed {
  const [, redraw] = useReducer((count: number) => count + 1, 0);
  const marginPx = useRef(0); // from the page's top to the table's body
  const options = {
    count: keys.length,
    getItemKey: (index: number) => keys[index] ?? index,
    getScrollElement: () => window,
    estimateSize: () => kRowPx,
    overscan: kAround,
    scrollMargin: marginPx.current,
    scrollToFn: windowScroll,
    observeElementRect: observeWindowRect,
    observeElementOffset: observeWindowOffset,
    initialRect: { width: window.innerWidth, height: window.innerHeight },
    initialOffset: () => window.scrollY,
    rangeExtractor: ({ startIndex, endIndex }: { readonly startIndex: number; readonly endIndex: number }) =>
      around(startIndex, endIndex, keys.length, kept),
    onChange: () => redraw(undefined),
  };
  const [virtualizer] = useState(() => new Virtualizer<Window, HTMLTableRowElement>(options));
  virtualizer.setOptions(options);
  useLayoutEffect(() => virtualizer._didMount(), [virtualizer]);
  useLayoutEffect(() => {
    virtualizer._willUpdate();
    const { current } = body;
    if (current === null) return;
    const top = Math.round(current.getBoundingClientRect().top + window.scrollY);
    if (top !== marginPx.current) {
      marginPx.current = top;
      redraw(undefined);
    }
    virtualizer.measureElement(null); // forgets those that left the page
    for (const row of current.querySelectorAll<HTMLTableRowElement>("tr[data-index]")) virtualizer.measureElement(row);
    keepWidths(current);
  });
  const items = virtualizer.getVirtualItems();
  let end = marginPx.current;
  const rows = items.map(({ index, start, size }) => {
    const abovePx = Math.max(0, start - end);
    end = start + size;
    return { index, abovePx };
  });
  return {
    rows,
    belowPx: Math.max(0, virtualizer.getTotalSize() - (end - marginPx.current)),
    bring: (index) => virtualizer.scrollToIndex(index, { align: "center" }),
  };
}

// In rising order.
export function around(first: number, last: number, count: number, kept: number | undefined): number[] {
  const from = Math.max(0, first - kAround);
  const to = Math.min(count - 1, last + kAround);
  const out = Array.from({ length: Math.max(0, to - from + 1) }, (_, i) => from + i);
  if (kept === undefined || kept >= count || (kept >= from && kept <= to)) return out;
  return kept < from ? [kept, ...out] : [...out, kept];
}

// A column is as wide as the widest cell that was in the page so far: it would jump with every row otherwise.
function keepWidths(body: HTMLTableSectionElement): void {
  for (const cell of body.parentElement?.querySelectorAll<HTMLTableCellElement>("thead th") ?? []) {
    const width = `${Math.floor(cell.getBoundingClientRect().width)}px`;
    if (Number.parseFloat(width) > Number.parseFloat(cell.style.minWidth || "0")) cell.style.minWidth = width;
  }
}
