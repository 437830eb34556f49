import { screenColor } from "./colors";
import { drawOver, type Gl, type Program } from "./gl";
import { revolved } from "./solids";
import { add, placed, scaled, turnBetween, unit, type Vec, lengthOf } from "./vec";

const kColor = "#c2410c";
const kArrowMmPerN = 1.5; // as the words say (tooth.force_arrow)
const kMaxMm = 6; // more would cover the cavity
// Of half the picture's height: as slim from near as from far.
const kShaft = 0.008;
const kHead = 0.06;

// The force on the hand as an arrow from the bur's tip, over the tooth.
export class ForceArrow {
  // A shaft that is drawn out along z, and a head for its end.
  private readonly shaft;
  private readonly head;
  private force: Vec | undefined;

  constructor(private readonly gl: Gl) {
    this.shaft = revolved(gl, [
      [0, kShaft],
      [1, kShaft],
    ]);
    this.head = revolved(gl, [
      [0, 3 * kShaft],
      [kHead, 0],
    ]);
  }

  // newton, scene frame; undefined: none is felt.
  set(forceN: Vec | undefined): void {
    this.force = forceN;
  }

  // `tip`: where it begins; undefined: no tool is drawn. `plain`: in use, with the picture's matrices. `halfHighMm`: half
  // the picture's height.
  draw(plain: Program, tip: Vec | undefined, halfHighMm: number): void {
    if (tip === undefined || this.force === undefined) return;
    const lengthMm = Math.min(kMaxMm, lengthOf(this.force) * kArrowMmPerN);
    const way = unit(this.force);
    const turn = turnBetween([0, 0, 1], way);
    drawOver(this.gl, { depth: false });
    plain.set("tint", [...screenColor(kColor), 1]);
    plain.set("model", placed(turn, tip, [halfHighMm, halfHighMm, lengthMm]));
    this.shaft.draw();
    plain.set("model", placed(turn, add(tip, scaled(way, lengthMm)), [halfHighMm, halfHighMm, halfHighMm]));
    this.head.draw();
  }

  dispose(): void {
    this.shaft.dispose();
    this.head.dispose();
  }
}
