// The colour of another tooth over the one in view: neither a tissue's colour nor one of the
// deviation scale's.
export const kGhostColor = "#00a88f";
