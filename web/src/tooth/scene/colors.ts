import { parseHex } from "../deviation_scale";
import { kStainColor, kTissues, tissueColor } from "../tissue_color";

// Colours as shaders take them: 0 … 1, of the screen (sRGB) or linear, as light adds up.

export type Rgb = readonly [number, number, number];

export function screenColor(hex: string): Rgb {
  const [r, g, b] = parseHex(hex);
  return [r / 255, g / 255, b / 255];
}
// IEC 61966-2-1.
export function linearColor(hex: string): Rgb {
  const [r, g, b] = screenColor(hex).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)) as [
    number,
    number,
    number,
  ];
  return [r, g, b];
}

// Of all tissues, one after the other; then of stain.
export function palette(color: (hex: string) => Rgb): number[] {
  return Array.from({ length: kTissues + 1 }, (_, i) => color(i < kTissues ? tissueColor(i) : kStainColor)).flat();
}
