// The part of an address that names the open moment and the view of the tooth:
// "?t=21.4&view=1.2_0.8_0.9_1".

export interface Look {
  readonly azimuthRad: number; // around the tooth's axis
  readonly polarRad: number; // from straight above
  readonly distance: number; // from what is looked at; 1: the whole tooth just fits into the picture
  readonly atCut: boolean; // looked at is the middle of what was cut; false: of the tooth
}

export interface MomentLink {
  readonly seconds: number | undefined;
  readonly look: Look | undefined;
}

const kMostSeconds = 86_400;
const kMostDistance = 20;

export function momentQuery({ seconds, look }: MomentLink): string {
  const query = new URLSearchParams();
  if (seconds !== undefined) query.set("t", String(Number(seconds.toFixed(2))));
  if (look !== undefined)
    query.set(
      "view",
      [look.azimuthRad, look.polarRad, look.distance, look.atCut ? 1 : 0]
        .map((value) => String(Number(value.toFixed(4))))
        .join("_"),
    );
  const text = query.toString();
  return text === "" ? "" : `?${text}`;
}

// What is no moment or view is left out: an address may come from anywhere.
export function momentOf(query: URLSearchParams): MomentLink {
  const seconds = number(query.get("t") ?? "", 0, kMostSeconds);
  const parts = (query.get("view") ?? "").split("_");
  const [azimuthRad, polarRad, distance] = [
    number(parts[0] ?? "", -7, 7),
    number(parts[1] ?? "", 0, 3.15),
    number(parts[2] ?? "", 0.01, kMostDistance),
  ];
  const at = parts.length === 4 ? number(parts[3] ?? "", 0, 1) : undefined;
  const look =
    azimuthRad === undefined || polarRad === undefined || distance === undefined || at === undefined
      ? undefined
      : { azimuthRad, polarRad, distance, atCut: at === 1 };
  return { seconds, look };
}

function number(text: string, least: number, most: number): number | undefined {
  const value = /^-?\d{1,6}(\.\d{1,6})?$/.test(text) ? Number(text) : Number.NaN;
  return value >= least && value <= most ? value : undefined;
}
