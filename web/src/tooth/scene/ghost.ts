import type { FilmScreen } from "../film";
import { kGhostColor } from "../line_colors";
import type { BlockMesh } from "../mesher";
import { ToothBlocks } from "./blocks";
import { screenColor } from "./colors";
import { drawOver, type Gl, Shape, type Stencil } from "./gl";
import type { Frame, Paint } from "./paint";
import { Section } from "./section";

// Another tooth over the one in view: translucent where it stands out of that one, and stripes on
// that one where the other has less left. Where both are the same nothing of it is seen, so that
// what was left untouched keeps its colours.
//
// Which places the other tooth does not reach is counted: along each line of sight, how often one
// goes into it and comes out again before it meets the tooth in view. Never, or as often out as in:
// that place is outside (as with shadow volumes: Heidmann, "Real shadows, real time", 1991). A
// section shows the other tooth as the outline of its cut alone.

export const kSameMm = 0.03; // apart or less is the same: triangles of both are made coarser in other places
const kFill = 0.5; // opacities
const kStripe = 0.75;
const kStripePx = 7; // of the picture, from one stripe to the next
const kMarked = 128; // in the stencil: the tooth that is looked at, and neither in the other nor out of it

const kCorners = [-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0];

// How the tooth in view is marked for the count.
export const kMarking: Stencil = { where: "always", write: "replace", mark: kMarked };

export class Ghost implements FilmScreen {
  readonly section: Section;
  private readonly blocks: ToothBlocks;
  private readonly everywhere: Shape; // the whole picture

  // `expected`: more of it comes soon; `changed`: asks for another drawing.
  constructor(
    private readonly gl: Gl,
    private readonly expected: () => void,
    private readonly changed: () => void,
  ) {
    this.section = new Section(gl, kGhostColor);
    this.blocks = new ToothBlocks(gl);
    this.everywhere = new Shape(gl, { position: { data: Float32Array.from(kCorners), size: 3 } }, undefined);
  }

  readonly parts = () => this.blocks.meshes();

  expect(): void {
    this.expected();
  }
  setBlock(index: number, mesh: BlockMesh | undefined): void {
    this.blocks.set(index, mesh);
    this.section.changed();
    this.changed();
  }
  // The visible bur belongs to the tooth in view, and so does what is framed.
  setBur(): void {}
  setOpened(): void {}
  setDetail(): void {}
  drawNow(): void {}
  setLooks(): void {}

  draw(paint: Paint, frame: Frame): void {
    if (frame.plane !== undefined) return;
    const { gl } = this;
    const tint = (opacity: number) => [...screenColor(kGhostColor), opacity];
    paint.ghost(frame, tint(kFill));
    drawOver(gl, { hides: false, mixed: true });
    this.blocks.draw(frame.picture);
    paint.count(frame);
    for (const [faces, write] of [
      ["front", "increment"],
      ["back", "decrement"],
    ] as const) {
      drawOver(gl, { hides: false, color: false, faces, stencil: { where: "always", write, mark: kMarked } });
      this.blocks.draw(frame.picture);
    }
    paint.stripes(tint(kStripe), kStripePx);
    drawOver(gl, { depth: false, mixed: true, stencil: { where: "equal", write: "keep", mark: kMarked } });
    this.everywhere.draw();
  }

  dispose(): void {
    this.blocks.dispose();
    this.section.dispose();
    this.everywhere.dispose();
  }
}
