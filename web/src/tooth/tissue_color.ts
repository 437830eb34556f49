// How tissues are drawn; index: the tissue number of a surface.
const kColors = ["#cccccc", "#f1e8d4", "#d9a95f", "#c7405f", "#5d4030", "#7fa3bf", "#cfd3c8", "#b9c9b2"] as const;

export const kTissues = kColors.length;

export function tissueColor(tissue: number): string {
  return kColors[tissue] ?? kColors[0];
}
