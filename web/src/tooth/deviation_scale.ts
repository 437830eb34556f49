// The colour scale of the deviation map: diverging, safe for the common colour vision deficiencies
// (ColorBrewer RdBu, 11 classes, its middle a little warmer), quiet where nothing is wrong; the
// same numbers for the 3-D picture and its legend.

export const kDeviationRangeMm = 0.5;
export const kContourStepMm = 0.1;
export const kUntouchedColor = "#a3abb5";

const kStops = [
  "#053061",
  "#2166ac",
  "#4393c3",
  "#92c5de",
  "#d1e5f0",
  "#f6f1e4",
  "#fddbc7",
  "#f4a582",
  "#d6604d",
  "#b2182b",
  "#67001f",
] as const;

export type Rgb = readonly [number, number, number];

export function parseHex(hex: string): Rgb {
  const value = Number.parseInt(hex.slice(1), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

// sRGB 0..255. Blue: less removed than the reference; ivory: as the reference; red: more removed.
// Beyond the range: the end colour. NaN: untouched.
export function deviationColor(deviationMm: number): Rgb {
  if (Number.isNaN(deviationMm)) return parseHex(kUntouchedColor);
  const unit = (deviationMm / kDeviationRangeMm + 1) / 2;
  const place = Math.min(Math.max(unit, 0), 1) * (kStops.length - 1);
  const lower = Math.min(Math.floor(place), kStops.length - 2);
  const a = parseHex(kStops[lower]!);
  const b = parseHex(kStops[lower + 1]!);
  const mix = (i: 0 | 1 | 2) => Math.round(a[i] + (b[i] - a[i]) * (place - lower));
  return [mix(0), mix(1), mix(2)];
}

// The scale as `width` RGBA pixels, from -range to +range.
export function deviationScalePixels(width: number): Uint8Array<ArrayBuffer> {
  const pixels = new Uint8Array(width * 4);
  for (let i = 0; i < width; ++i) {
    const [r, g, b] = deviationColor(((2 * i) / (width - 1) - 1) * kDeviationRangeMm);
    pixels.set([r, g, b, 255], 4 * i);
  }
  return pixels;
}
