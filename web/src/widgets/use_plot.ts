import { useEffect, useRef, useState } from "preact/hooks";
import type { RefObject } from "preact";
import type uPlot from "uplot";
import { Disposables } from "../base/disposables";
import { keepTrying } from "../base/keep_trying";
import { numberText } from "../base/language";

export interface PlotInput {
  readonly options: uPlot.Options;
  readonly data: uPlot.AlignedData;
}

export interface PlotFrame {
  readonly frame: RefObject<HTMLDivElement | null>; // give it to the element that the plot fills
  readonly plot: RefObject<uPlot | null>; // null until uPlot is loaded
}

// A uPlot in a div: loaded when first needed, replaced when an input or the colour scheme changes,
// as wide as its div. `created` may listen to it and add what is undone with it; `resized` runs
// after it has a new width.
export function usePlot(
  describe: (element: HTMLElement) => PlotInput,
  inputs: readonly unknown[],
  created?: (plot: uPlot, cleanup: Disposables) => void,
  resized?: () => void,
): PlotFrame {
  const frame = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot>(null);
  const dark = useDarkScheme();
  const latest = useRef({ describe, created, resized });
  latest.current = { describe, created, resized };

  useEffect(() => {
    const element = frame.current;
    if (element === null) return undefined;
    const cleanup = new Disposables();
    const shown = new AbortController();
    cleanup.add(() => shown.abort());
    void keepTrying(() => import("uplot"), shown.signal).then(({ default: UPlot }) => {
      if (shown.signal.aborted) return;
      const { options, data } = latest.current.describe(element);
      const made = new UPlot(options, data, element);
      plot.current = made;
      cleanup.add(() => {
        made.destroy();
        plot.current = null;
      });
      latest.current.created?.(made, cleanup);
      const observer = new ResizeObserver(() => {
        // It is told of the first width too, which the plot has: all of it would be drawn once more.
        const width = element.clientWidth;
        if (made.width !== width) made.setSize({ width, height: options.height });
        queueMicrotask(() => latest.current.resized?.()); // uPlot lays itself out in one before
      });
      observer.observe(element);
      cleanup.add(() => observer.disconnect());
      latest.current.resized?.();
    });
    return () => cleanup.dispose();
  }, [...inputs, dark]);

  return { frame, plot };
}

export interface PlotStyle {
  readonly color: (variable: string) => string; // of a CSS custom property
  readonly axis: uPlot.Axis;
}

const kTickDecimals = 4;

export function plotStyle(element: HTMLElement): PlotStyle {
  const style = getComputedStyle(element);
  const color = (variable: string) => style.getPropertyValue(variable).trim();
  const font = `12px ${style.fontFamily}`;
  const line = { stroke: color("--line"), width: 1 };
  // The page's language, where uPlot would take the browser's. Null: no place for a number there.
  const values = (_: uPlot, splits: (number | null)[]) =>
    splits.map((value) => (value === null ? "" : numberText(value, 0, kTickDecimals)));
  return {
    color,
    axis: { stroke: color("--text-soft"), grid: line, ticks: line, font, labelFont: font, labelSize: 18, values },
  };
}

export function withAlpha(hex: string, alpha: string): string {
  return /^#[0-9a-f]{6}$/i.test(hex) ? hex + alpha : hex;
}

export function useDarkScheme(): boolean {
  const [dark, setDark] = useState(() => matchMedia("(prefers-color-scheme: dark)").matches);
  useEffect(() => {
    const cleanup = new Disposables();
    const query = matchMedia("(prefers-color-scheme: dark)");
    cleanup.listen(query, "change", () => setDark(query.matches));
    return () => cleanup.dispose();
  }, []);
  return dark;
}
