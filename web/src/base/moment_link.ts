// The part of an address that names the open moment and the view of the tooth:
// "?t=21.4&view=1.2_0.8_4.5_0_0.1_2".

export interface Look {
  readonly azimuthRad: number; // around the tooth's axis
  readonly polarRad: number; // from straight above
  readonly fitsMm: number; // radius of the ball that just fits into the picture, whatever its size
  readonly centreMm: readonly [number, number, number]; // what is looked at, scene frame
}

const kSame = 1e-4; // mm and rad: less is rounding

export function sameLook(a: Look, b: Look): boolean {
  const numbers = (look: Look) => [look.azimuthRad, look.polarRad, look.fitsMm, ...look.centreMm];
  const theirs = numbers(b);
  return numbers(a).every((value, i) => Math.abs(value - (theirs[i] ?? Number.NaN)) < kSame);
}

export interface MomentLink {
  readonly seconds: number | undefined;
  readonly look: Look | undefined;
}

const kMaxSeconds = 86_400;
const kMaxMm = 500;

export function momentQuery({ seconds, look }: MomentLink): string {
  const query = new URLSearchParams();
  if (seconds !== undefined) query.set("t", String(Number(seconds.toFixed(2))));
  if (look !== undefined)
    query.set(
      "view",
      [look.azimuthRad, look.polarRad, look.fitsMm, ...look.centreMm]
        .map((value) => String(Number(value.toFixed(4))))
        .join("_"),
    );
  const text = query.toString();
  return text === "" ? "" : `?${text}`;
}

// What is no moment or view is left out: an address may come from anywhere.
export function momentOf(query: URLSearchParams): MomentLink {
  const seconds = number(query.get("t") ?? "", 0, kMaxSeconds);
  const parts = (query.get("view") ?? "").split("_");
  const kRanges = [[-7, 7], [0, 3.15], [0.01, kMaxMm], ...[0, 1, 2].map(() => [-kMaxMm, kMaxMm])] as const;
  const [azimuthRad, polarRad, fitsMm, x, y, z] =
    parts.length === kRanges.length
      ? kRanges.map(([least = 0, most = 0], i) => number(parts[i] ?? "", least, most))
      : [];
  const look =
    azimuthRad === undefined ||
    polarRad === undefined ||
    fitsMm === undefined ||
    x === undefined ||
    y === undefined ||
    z === undefined
      ? undefined
      : { azimuthRad, polarRad, fitsMm, centreMm: [x, y, z] as const };
  return { seconds, look };
}

function number(text: string, least: number, most: number): number | undefined {
  const value = /^-?\d{1,6}(\.\d{1,6})?$/.test(text) ? Number(text) : Number.NaN;
  return value >= least && value <= most ? value : undefined;
}
