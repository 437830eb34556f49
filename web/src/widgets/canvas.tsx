import { useEffect, useRef } from "preact/hooks";
import { Disposables } from "../base/disposables";
import { FrameScheduler } from "../base/frame";

export interface Drawing {
  readonly context: CanvasRenderingContext2D; // scaled so that a unit is a CSS pixel; cleared
  readonly width: number;
  readonly height: number;
  readonly color: (variable: string) => string; // of the style sheet, so that dark and light both work
}

interface Props {
  readonly className: string;
  readonly label: string; // what the picture shows, for who cannot see it
  readonly draw: (drawing: Drawing) => void;
  readonly stamp: unknown; // drawn again whenever this changes
}

// A picture that is drawn often: at most once per frame, sharp on every screen.
export function Canvas({ className, label, draw, stamp }: Props) {
  const element = useRef<HTMLCanvasElement>(null);
  const latest = useRef(draw);
  latest.current = draw;
  const frame = useRef<FrameScheduler | undefined>(undefined);
  useEffect(() => {
    const canvas = element.current;
    if (canvas === null) return undefined;
    const cleanup = new Disposables();
    const scheduler = new FrameScheduler(() => paint(canvas, latest.current));
    frame.current = scheduler;
    cleanup.add(() => scheduler.cancel());
    const observer = new ResizeObserver(() => scheduler.request());
    observer.observe(canvas);
    cleanup.add(() => observer.disconnect());
    cleanup.listen(matchMedia("(prefers-color-scheme: dark)"), "change", () => scheduler.request());
    return () => cleanup.dispose();
  }, []);
  useEffect(() => frame.current?.request(), [stamp]);
  return <canvas ref={element} class={className} role="img" aria-label={label} />;
}

function paint(canvas: HTMLCanvasElement, draw: (drawing: Drawing) => void): void {
  const { clientWidth: width, clientHeight: height } = canvas;
  const context = canvas.getContext("2d");
  if (context === null || width === 0 || height === 0) return;
  const ratio = Math.min(window.devicePixelRatio, 2);
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  const style = getComputedStyle(canvas);
  draw({ context, width, height, color: (variable) => style.getPropertyValue(variable).trim() });
}
