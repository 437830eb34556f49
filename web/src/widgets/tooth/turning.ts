import { Disposables } from "../../base/disposables";

// Turns and nears what is drawn in an element by the pointer: a mouse or one finger turns it, two fingers and, where
// `zooms` allows, the wheel near it.

export interface Turned {
  turn(azimuthRad: number, polarRad: number): void;
  zoom(factor: number): void;
}

const kWheelStep = 0.95; // of the distance, at 100 px of wheel
const kWheelPx = 100;
const kLinePx = 16;

export function turnedBy(element: HTMLElement, { turn, zoom }: Turned, zooms: () => boolean): () => void {
  const cleanup = new Disposables();
  const places = new Map<number, readonly [number, number]>();
  const apart = () => {
    const [a, b] = [...places.values()];
    return a === undefined || b === undefined ? 0 : Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  // A finger may still scroll the page over the picture; sideways it turns the tooth.
  element.style.touchAction = "pan-y";
  cleanup.listen(element, "pointerdown", (event) => {
    const { pointerId, clientX, clientY, button } = event as PointerEvent;
    if (button !== 0) return;
    element.setPointerCapture(pointerId);
    places.set(pointerId, [clientX, clientY]);
  });
  cleanup.listen(element, "pointermove", (event) => {
    const { pointerId, clientX, clientY } = event as PointerEvent;
    const before = places.get(pointerId);
    if (before === undefined) return;
    const was = apart();
    places.set(pointerId, [clientX, clientY]);
    if (places.size === 2 && was > 0) return zoom(was / Math.max(apart(), 1));
    if (places.size !== 1) return;
    // Once around for the picture's height.
    const radPerPx = (2 * Math.PI) / element.clientHeight;
    turn(-(clientX - before[0]) * radPerPx, -(clientY - before[1]) * radPerPx);
  });
  for (const end of ["pointerup", "pointercancel"])
    cleanup.listen(element, end, (event) => places.delete((event as PointerEvent).pointerId));
  cleanup.listen(
    element,
    "wheel",
    (event) => {
      if (!zooms()) return;
      event.preventDefault();
      const { deltaY, deltaMode } = event as WheelEvent;
      zoom(kWheelStep ** -((deltaY * (deltaMode === 0 ? 1 : kLinePx)) / kWheelPx));
    },
    { passive: false },
  );
  return () => cleanup.dispose();
}
