import type { Effort } from "../messages";

// Renderers that draw on the processor: SwiftShader (Chromium), llvmpipe and softpipe (Mesa),
// Microsoft's WARP and basic driver.
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render|\bwarp\b/i;

// Whether a renderer's name, as the browser tells it, stands for one without a graphics card. Many
// samples in each pixel and an elaborate light cost a card nothing, and a processor most of its
// time.
export function isSoftware(renderer: string): boolean {
  return kSoftware.test(renderer);
}

let known: boolean | undefined;

// Asked with a context of its own, once: antialiasing is chosen before a context can be asked.
// (`failIfMajorPerformanceCaveat` does not tell: Chromium gives its own software renderer all the
// same.)
export function drawsSlowly(): boolean {
  if (known !== undefined) return known;
  const context = new OffscreenCanvas(1, 1).getContext("webgl2", { antialias: false, depth: false });
  if (context === null) return false;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  known = isSoftware(String(context.getParameter(names === null ? context.RENDERER : names.UNMASKED_RENDERER_WEBGL)));
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return known;
}

export type { Effort };

const kQuickShare = 0.5; // of the pixels along each side
const kMaxPerCssPixel = 2;

// Pixels for each CSS pixel.
export function pixelRatio(effort: Effort, device: number): number {
  return effort === "quick" ? kQuickShare : Math.min(device, kMaxPerCssPixel);
}

const kSettleMs = 250; // without a change, until it is drawn in full
const kAwaitedMs = 2000; // the same while more is expected: drawn in full it would only keep that waiting

// Where drawing is slow, what moves is drawn quickly, and in full once nothing has changed for a
// while. Where it is not, always in full.
export class DrawingPace {
  private calledOff = (): void => {};
  private current: Effort = "full";

  // `later`: calls a function after a while, unless the returned one cancels it.
  constructor(
    private readonly slow: boolean,
    private readonly redraw: () => void,
    private readonly rests: () => void, // nothing has changed for a while
    private readonly later: (act: () => void, ms: number) => () => void = whenStill,
  ) {}

  get effort(): Effort {
    return this.current;
  }
  // Something has changed and is drawn next. `more`: and changes soon again.
  moved(more = false): void {
    this.calledOff();
    this.calledOff = this.later(() => this.settle(), more ? kAwaitedMs : kSettleMs);
    if (this.slow) this.current = "quick";
  }
  // Draws in full now, when it was quick.
  settle(): void {
    this.calledOff();
    if (this.current === "quick") {
      this.current = "full";
      this.redraw();
    }
    this.rests();
  }
  stop(): void {
    this.calledOff();
  }
}

function whenStill(act: () => void, ms: number): () => void {
  const timer = setTimeout(act, ms);
  return () => clearTimeout(timer);
}
