import { deviationScalePixels, kUntouchedColor } from "../deviation_scale";
import type { Effort } from "../messages";
import { linearColor, palette, type Rgb, screenColor } from "./colors";
import { type Gl, Program, type Uniform } from "./gl";
import {
  kFullFragment,
  kFullVertex,
  kGhostFragment,
  kPlainFragment,
  kPlainVertex,
  kQuickFragment,
  kQuickVertex,
  kStripeFragment,
  kStripeVertex,
} from "./shaders";
import { kUnmoved, type Matrix } from "./vec";

// The programs that a scene is drawn with, made when they are first needed.

const kInsideColor = "#b98a5e"; // of a cut whose tissues are not known
const kScalePixels = 256;
const kTooth = { roughness: 0.55, metal: 0 };
const kSteel = { color: "#8a94a0", roughness: 0.35, metal: 0.6 };

// Of the picture that is drawn.
export interface Frame {
  readonly view: Matrix; // from the scene to the camera
  readonly projection: Matrix; // from the camera to −1 … 1
  readonly picture: Matrix; // both
  readonly plane: readonly number[] | undefined; // what is behind it is not drawn
  readonly toSlice: readonly number[]; // three rows (cut_fill.ts), where there is a plane; 0: the tissues behind it are not known
}

type Kind = "full" | "quick" | "ghost" | "count" | "stripes" | "plain";

export class Paint {
  private readonly programs = new Map<string, Program>();
  private readonly scale: WebGLTexture;
  private readonly palettes: Readonly<Record<Effort, readonly number[]>> = {
    full: palette(linearColor),
    quick: palette(screenColor),
  };
  heat = false; // the deviation instead of the tissues

  // `shiftMm`: apart or less is the same, for another tooth over this one.
  constructor(
    private readonly gl: Gl,
    private readonly shiftMm: number,
  ) {
    this.scale = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.scale);
    gl.texImage2D(
      gl.TEXTURE_2D,
      0,
      gl.RGBA,
      kScalePixels,
      1,
      0,
      gl.RGBA,
      gl.UNSIGNED_BYTE,
      deviationScalePixels(kScalePixels),
    );
    for (const [name, value] of [
      [gl.TEXTURE_MIN_FILTER, gl.LINEAR],
      [gl.TEXTURE_MAG_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
    ] as const)
      gl.texParameteri(gl.TEXTURE_2D, name, value);
  }

  dispose(): void {
    for (const program of this.programs.values()) program.dispose();
    this.gl.deleteTexture(this.scale);
  }

  tooth(effort: Effort, frame: Frame): void {
    const color = effort === "full" ? linearColor : screenColor;
    this.use(effort, frame, { ...kTooth, ...this.colors(color), palette: this.palettes[effort] });
  }
  bur(frame: Frame, model: Matrix): void {
    const { color, roughness, metal } = kSteel;
    const whole = { ...frame, plane: undefined };
    this.use("full", whole, { roughness, metal, model, heat: 0, palette: linearColor(color) });
  }
  ghost(frame: Frame, tint: readonly number[]): void {
    this.use("ghost", frame, { tint });
  }
  // Without a colour.
  count(frame: Frame): void {
    this.use("count", frame, {});
  }
  stripes(tint: readonly number[], width: number): void {
    this.program("stripes", false).use({ tint, width });
  }
  // In one colour (`tint`), where `model` puts it.
  plain({ view, projection }: Frame): Program {
    const program = this.program("plain", false);
    program.use({ view, projection, model: kUnmoved, dash: 0 });
    return program;
  }

  private colors(color: (hex: string) => Rgb) {
    return { heat: this.heat ? 1 : 0, untouched: color(kUntouchedColor), inside: screenColor(kInsideColor) };
  }
  private use(kind: Kind, { view, projection, plane, toSlice }: Frame, more: Readonly<Record<string, Uniform>>): void {
    const program = this.program(kind, plane !== undefined);
    program.use({ view, projection, model: kUnmoved, ...(plane === undefined ? {} : { plane, toSlice }), ...more });
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.scale);
  }
  private program(kind: Kind, cut: boolean): Program {
    const key = `${kind} ${cut}`;
    const known = this.programs.get(key);
    if (known !== undefined) return known;
    const made = this.make(kind, cut ? ["CUT"] : []);
    this.programs.set(key, made);
    return made;
  }
  private make(kind: Kind, defines: readonly string[]): Program {
    const shift = (mm: number) => [...defines, `SHIFT ${mm.toFixed(4)}`];
    switch (kind) {
      case "full":
        return new Program(this.gl, kFullVertex, kFullFragment, defines);
      case "quick":
        return new Program(this.gl, kQuickVertex, kQuickFragment, defines);
      // A little towards the side on which it counts as the same.
      case "ghost":
        return new Program(this.gl, kQuickVertex, kGhostFragment, shift(-this.shiftMm));
      case "count":
        return new Program(this.gl, kQuickVertex, kGhostFragment, shift(this.shiftMm));
      case "stripes":
        return new Program(this.gl, kStripeVertex, kStripeFragment);
      case "plain":
        return new Program(this.gl, kPlainVertex, kPlainFragment);
    }
  }
}
