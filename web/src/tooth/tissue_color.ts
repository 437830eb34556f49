// How tissues are drawn; index: the tissue number of a surface.
const kColors = ["#cccccc", "#f2ead6", "#e2bb74", "#ba2e30", "#704a2c", "#7fa3bf", "#cfd3c8", "#b9c9b2"] as const;
// Of fissures and pits.
export const kStainColor = "#685442";

// Of a lesion: its border in enamel, and what is soft.
export const kLesionColors = ["#f8f8f2", "#b27c3c"] as const;

export const kTissues = kColors.length;

export function tissueColor(tissue: number): string {
  return kColors[tissue] ?? kColors[0];
}
