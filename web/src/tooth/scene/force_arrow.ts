import { screenColor } from "./colors";
import { drawOver, type Gl, type Program } from "./gl";
import { revolved } from "./solids";
import { add, placed, scaled, turnBetween, unit, type Vec, lengthOf } from "./vec";

const kColor = "#c2410c";
const kArrowMmPerN = 1.5; // as the words say (tooth.force_arrow)
const kMostMm = 12;
const kShaftMm = 0.09;
const kHeadMm = 0.55;

// The force on the hand as an arrow from the bur's tip, over the tooth.
export class ForceArrow {
  // A shaft of 1 mm that is drawn out along z, and a head for its end.
  private readonly shaft;
  private readonly head;
  private force: Vec | undefined;

  constructor(private readonly gl: Gl) {
    this.shaft = revolved(gl, [
      [0, kShaftMm],
      [1, kShaftMm],
    ]);
    this.head = revolved(gl, [
      [0, 3 * kShaftMm],
      [kHeadMm, 0],
    ]);
  }

  // newton, scene frame; undefined: none is felt.
  set(forceN: Vec | undefined): void {
    this.force = forceN;
  }

  // `tip`: where it begins; undefined: no tool is drawn. `plain`: in use, with the picture's matrices.
  draw(plain: Program, tip: Vec | undefined): void {
    if (tip === undefined || this.force === undefined) return;
    const lengthMm = Math.min(kMostMm, lengthOf(this.force) * kArrowMmPerN);
    const way = unit(this.force);
    const turn = turnBetween([0, 0, 1], way);
    drawOver(this.gl, { depth: false });
    plain.set("tint", [...screenColor(kColor), 1]);
    plain.set("model", placed(turn, tip, [1, 1, lengthMm]));
    this.shaft.draw();
    plain.set("model", placed(turn, add(tip, scaled(way, lengthMm))));
    this.head.draw();
  }

  dispose(): void {
    this.shaft.dispose();
    this.head.dispose();
  }
}
