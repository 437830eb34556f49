// Of what is drawn over a tooth, for its pictures and their legends.

// Another tooth over the one in view: neither a tissue's colour nor one of the deviation scale's.
export const kGhostColor = "#00a88f";
// What the exercise asks for.
export const kTargetColor = "#6d28d9";
// The edge of a section.
export const kCutColor = "#8c1d18";
