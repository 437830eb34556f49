// How tissues are drawn; index: the tissue number of a surface.
const kColors = ["#cccccc", "#f2ead6", "#e2bb74", "#ba2e30", "#704a2c", "#7fa3bf", "#cfd3c8", "#b9c9b2"] as const;
// Of fissures and pits.
export const kStainColor = "#685442";

export const kTissues = kColors.length;

export function tissueColor(tissue: number): string {
  return kColors[tissue] ?? kColors[0];
}
