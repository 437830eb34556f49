import type { BlockMesh } from "../../api/tooth_mesh";
import type { Extent } from "../../api/tooth_work";

// How a tooth that is played back reaches the picture: block by block, as it changes.

export interface FilmPose {
  readonly tipMm: readonly [number, number, number];
  readonly axis: readonly [number, number, number]; // toward the shank
}

export interface FilmScreen {
  // More comes soon: another moment was asked for.
  expect(): void;
  // A part of the tooth; undefined: no surface there.
  setBlock(index: number, mesh: BlockMesh | undefined): void;
  // The bur's outline (place along the axis, radius; mm) and where it is; undefined: it is not
  // shown.
  setBur(outline: readonly (readonly [number, number])[], pose: FilmPose | undefined): void;
}

// How much of the tooth the screens were given.
export type Detail = "none" | "coarse" | "fine";

export interface Film {
  readonly extent: Extent;
  readonly detail: Detail;
  // Gives the screen all there is, and what changes from then on. Returns what ends that.
  attach(screen: FilmScreen): () => void;
}
