import type { PointMm, ToothLines } from "../messages";
import { kTargetColor } from "../line_colors";
import { drawOver, type Gl, type Program, Shape } from "./gl";
import { screenColor } from "./colors";
import { lengthOf, sub } from "./vec";

const kDashMm = 0.12;

// Lines over the tooth, as they are given.
export class LineGroup {
  private shapes: readonly (readonly [Shape, opacity: number, dashMm: number])[] = [];

  constructor(private readonly gl: Gl) {}

  set(lines: ToothLines | undefined): void {
    this.dispose();
    if (lines === undefined) return;
    this.shapes = [
      [segments(this.gl, lines.solid), 0.9, 0],
      [segments(this.gl, lines.faint), 0.65, kDashMm],
    ];
  }

  // `plain`: in use, with the picture's matrices.
  draw(plain: Program): void {
    drawOver(this.gl, { depth: false, mixed: true });
    for (const [shape, opacity, dash] of this.shapes) {
      plain.set("tint", [...screenColor(kTargetColor), opacity]);
      plain.set("dash", dash);
      shape.draw();
    }
    plain.set("dash", 0);
  }

  dispose(): void {
    for (const [shape] of this.shapes) shape.dispose();
    this.shapes = [];
  }
}

function segments(gl: Gl, ways: readonly (readonly PointMm[])[]): Shape {
  const position: number[] = [];
  const along: number[] = [];
  for (const way of ways) {
    let before = 0;
    for (let i = 1; i < way.length; ++i) {
      const after = before + lengthOf(sub(way[i]!, way[i - 1]!));
      position.push(...way[i - 1]!, ...way[i]!);
      along.push(before, after);
      before = after;
    }
  }
  return new Shape(
    gl,
    { position: { data: Float32Array.from(position), size: 3 }, along: { data: Float32Array.from(along), size: 1 } },
    undefined,
    gl.LINES,
  );
}
