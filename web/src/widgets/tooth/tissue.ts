import { say } from "../../base/words";

// How tissues are named; index: the tissue number of a surface.
export const kTissueNames = ["air", "enamel", "dentin", "pulp", "caries", "filling", "gypsum", "neighbour"] as const;

export function tissueTitle(tissue: number): string {
  const name = kTissueNames[tissue];
  return name === undefined ? say("tooth_tissue.other", { number: String(tissue) }) : say(`tooth_tissue.${name}`);
}

const kOfTeeth = ["enamel", "dentin", "pulp", "caries"];

// What the picture shows, in a word: exercises are also cut in blocks of one material.
export function workpiece(tissues: readonly number[]): "tooth" | "block" {
  return tissues.length === 0 || tissues.some((tissue) => kOfTeeth.includes(kTissueNames[tissue] ?? ""))
    ? "tooth"
    : "block";
}
