import type { StudioAsk } from "./messages";

// A canvas for the screen that is opened next: its worker makes it ready while nobody knows yet where it will be. Throws
// where the browser has no such canvas.
export function canvasAhead(worker: { postMessage(asked: StudioAsk, transfer: Transferable[]): void }) {
  const canvas = document.createElement("canvas");
  const ahead = canvas.transferControlToOffscreen();
  worker.postMessage({ ahead }, [ahead]);
  return canvas;
}
