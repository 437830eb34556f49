import { Color } from "three";
import { tissueColor } from "./tissue";

// Of each vertex, as the graphics card takes it: linear, a byte for red, green and blue.
export function tissueColors(tissue: Uint8Array): Uint8Array<ArrayBuffer> {
  const table = palette();
  const colors = new Uint8Array(3 * tissue.length);
  for (let i = 0, at = 0; i < tissue.length; ++i) {
    const from = 3 * tissue[i]!;
    colors[at++] = table[from]!;
    colors[at++] = table[from + 1]!;
    colors[at++] = table[from + 2]!;
  }
  return colors;
}

let made: Uint8Array | undefined;
function palette(): Uint8Array {
  if (made !== undefined) return made;
  made = new Uint8Array(3 * 256);
  for (let i = 0; i < 256; ++i) {
    const linear = new Color(tissueColor(i));
    made.set([linear.r * 255, linear.g * 255, linear.b * 255], 3 * i);
  }
  return made;
}
