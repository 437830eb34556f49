// The visible part of the time, seconds.
export type View = readonly [number, number];

const kMinS = 0.1; // a hundred ticks
export const kZoomStep = 1.5;

// `by` times as long a part; what is at `atS` stays where it is. All of it: undefined.
export function zoomed(whole: View, view: View | undefined, atS: number, by: number): View | undefined {
  const [from, to] = view ?? whole;
  const all = whole[1] - whole[0];
  const length = Math.max((to - from) * by, kMinS);
  if (!(length < all)) return undefined;
  const share = Math.min(1, Math.max(0, (atS - from) / (to - from)));
  return moved(whole, atS - share * length, length);
}

// As long a part, `byS` later.
export function panned(whole: View, view: View | undefined, byS: number): View | undefined {
  return view === undefined ? undefined : moved(whole, view[0] + byS, view[1] - view[0]);
}

// As long a part with `atS` in it: the same where it is, else with it in the middle.
export function showing(whole: View, view: View | undefined, atS: number): View | undefined {
  if (view === undefined || (atS >= view[0] && atS <= view[1])) return view;
  const length = view[1] - view[0];
  return moved(whole, atS - length / 2, length);
}

function moved([first, last]: View, fromS: number, length: number): View {
  const from = Math.min(Math.max(fromS, first), last - length);
  return [from, from + length];
}
