import { say } from "../../base/words";

// How tissues are drawn and named; index: the tissue number of a surface.
export const kTissueNames = ["air", "enamel", "dentin", "pulp", "caries", "filling", "gypsum", "neighbour"] as const;
const kColors = ["#cccccc", "#f1e8d4", "#d9a95f", "#c7405f", "#5d4030", "#7fa3bf", "#cfd3c8", "#b9c9b2"] as const;

export function tissueColor(tissue: number): string {
  return kColors[tissue] ?? kColors[0];
}

export function tissueTitle(tissue: number): string {
  const name = kTissueNames[tissue];
  return name === undefined ? say("tooth_tissue.other", { number: String(tissue) }) : say(`tooth_tissue.${name}`);
}

export function tissuesPresent(tissue: Uint8Array): number[] {
  return [...new Set(tissue)].sort((a, b) => a - b);
}

const kOfTeeth = ["enamel", "dentin", "pulp", "caries"];

// What the picture shows, in a word: exercises are also cut in blocks of one material.
export function workpiece(tissues: readonly number[]): "tooth" | "block" {
  return tissues.length === 0 || tissues.some((tissue) => kOfTeeth.includes(kTissueNames[tissue] ?? ""))
    ? "tooth"
    : "block";
}
