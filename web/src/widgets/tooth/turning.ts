import { Disposables } from "../../base/disposables";

// Turns, moves and nears what is drawn in an element by the pointer, as usual in viewers of solids. The left button or
// one finger turns it; the right or middle button, the left one with Shift, and two fingers move it; two fingers and,
// where `zooms` allows, the wheel near it; a double click looks at a place.

export interface Turned {
  turn(azimuthRad: number, polarRad: number): void;
  // Of half the picture's height: where one looks from then on.
  pan(right: number, up: number): void;
  zoom(factor: number): void;
  lookAt(xPx: number, yPx: number): void; // from the top left
}

type Place = readonly [number, number]; // px to the right and down
type Two = readonly [Place, Place];

const kWheelStep = 0.95; // of the distance, at 100 px of wheel
const kWheelPx = 100;
const kLinePx = 16;

// What two fingers did: how far their middle moved, and how much nearer the eye comes.
export function pinched(was: Two, now: Two): { readonly moved: Place; readonly factor: number } {
  const middle = ([a, b]: Two): Place => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  const apart = ([a, b]: Two) => Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1]));
  const [before, after] = [middle(was), middle(now)];
  return { moved: [after[0] - before[0], after[1] - before[1]], factor: apart(was) / apart(now) };
}

export function turnedBy(element: HTMLElement, { turn, pan, zoom, lookAt }: Turned, zooms: () => boolean): () => void {
  const cleanup = new Disposables();
  const places = new Map<number, Place>();
  let pans = false; // the button that is pressed moves the picture
  const two = (): Two | undefined => {
    const [a, b] = [...places.values()];
    return a === undefined || b === undefined ? undefined : [a, b];
  };
  // What is drawn follows the pointer.
  const drag = ([right, down]: Place) => {
    const half = element.clientHeight / 2;
    pan(-right / half, down / half);
  };
  // A finger on the tooth never scrolls the page: beside the tooth it does.
  element.style.touchAction = "none";
  cleanup.listen(element, "pointerdown", (event) => {
    const { pointerId, clientX, clientY, button, shiftKey } = event as PointerEvent;
    if (button > 2) return;
    if (button === 1) event.preventDefault(); // scrolls the page otherwise
    pans = button !== 0 || shiftKey;
    element.setPointerCapture(pointerId);
    places.set(pointerId, [clientX, clientY]);
  });
  cleanup.listen(element, "pointermove", (event) => {
    const { pointerId, clientX, clientY } = event as PointerEvent;
    const before = places.get(pointerId);
    if (before === undefined) return;
    const was = two();
    places.set(pointerId, [clientX, clientY]);
    const now = two();
    if (was !== undefined && now !== undefined) {
      const { moved, factor } = pinched(was, now);
      drag(moved);
      zoom(factor);
      return;
    }
    const moved: Place = [clientX - before[0], clientY - before[1]];
    if (pans) return drag(moved);
    // Once around for the picture's height.
    const radPerPx = (2 * Math.PI) / element.clientHeight;
    turn(-moved[0] * radPerPx, -moved[1] * radPerPx);
  });
  for (const end of ["pointerup", "pointercancel"])
    cleanup.listen(element, end, (event) => places.delete((event as PointerEvent).pointerId));
  cleanup.listen(element, "contextmenu", (event) => event.preventDefault());
  cleanup.listen(element, "dblclick", (event) => {
    const { offsetX, offsetY } = event as MouseEvent;
    lookAt(offsetX, offsetY);
  });
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
