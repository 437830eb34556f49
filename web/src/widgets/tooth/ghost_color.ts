// Of another tooth that lies over the one that is looked at: neither a tissue's colour nor one of the deviation scale's.
export const kGhostColor = "#00a88f";
