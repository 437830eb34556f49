import { deviationScalePixels, kUntouchedColor } from "../deviation_scale";
import type { Effort } from "../messages";
import { linearColor, palette, screenColor } from "./colors";
import { type Gl, kAttributes, Program, type Uniform } from "./gl";
import { drawsSlowly } from "./renderer";
import {
  kFullFragment,
  kFullVertex,
  kGhostFragment,
  kGlassFragment,
  kPlainFragment,
  kPlainVertex,
  kQuickFragment,
  kQuickVertex,
  kStripeFragment,
  kStripeVertex,
  lampWays,
} from "./shaders";
import { kUnmoved, type Matrix } from "./vec";

// A canvas with its WebGL context, and the programs that a scene is drawn with, made when they are first needed.

const kInsideColor = "#b98a5e"; // of a cut whose tissues are not known
const kScalePixels = 256;
const kTooth = { roughness: 0.45, metal: 0 };
const kGlassColor = "#1f2937";
const kGlassEdge = 0.8; // opacity
const kSteel = { color: "#8a94a0", roughness: 0.35, metal: 0.6 };

// Of the picture that is drawn.
export interface Frame {
  readonly view: Matrix; // from the scene to the camera
  readonly projection: Matrix; // from the camera to −1 … 1
  readonly picture: Matrix; // both
  readonly plane: readonly number[] | undefined; // what is behind it is not drawn
  readonly toSlice: readonly number[]; // three rows (cut_fill.ts), where there is a plane; 0: the tissues behind it are not known
}

type Kind = "full" | "glass" | "quick" | "ghost" | "count" | "stripes" | "plain";

export class Paint {
  private readonly programs = new Map<string, Program>();
  private readonly scale: WebGLTexture;
  private readonly palettes: Readonly<Record<Effort, readonly number[]>> = {
    full: palette(linearColor),
    quick: palette(screenColor),
  };
  heat = false; // the deviation instead of the tissues
  translucent = false; // every block has what shines through it
  readonly gl: Gl;

  // `shiftMm`: apart or less is the same, for another tooth over this one. Throws where WebGL 2 is not available.
  constructor(
    readonly canvas: OffscreenCanvas,
    private readonly shiftMm: number,
  ) {
    const gl = canvas.getContext("webgl2", { antialias: !drawsSlowly(), stencil: true, powerPreference: "low-power" });
    if (gl === null) throw new Error("expected WebGL 2");
    this.gl = gl;
    gl.vertexAttrib4f(kAttributes.own, 0, 0, 0, 0); // of who has none
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

  // Has the browser make the first picture's program.
  prepare(): void {
    this.tooth(drawsSlowly() ? "quick" : "full", {
      view: kUnmoved,
      projection: kUnmoved,
      picture: kUnmoved,
      plane: undefined,
      toSlice: [],
    });
  }

  tooth(effort: Effort, frame: Frame): void {
    const color = effort === "full" ? linearColor : screenColor;
    const colors = { untouched: color(kUntouchedColor), inside: screenColor(kInsideColor) };
    this.use(
      effort,
      frame,
      { ...kTooth, ...colors, palette: this.palettes[effort], translucent: this.translucent ? 1 : 0 },
      this.heat ? "HEAT" : "TISSUE",
    );
  }
  // `glass`: nothing of it but its outline covers what is behind it.
  bur(frame: Frame, model: Matrix, glass: boolean): void {
    const { color, roughness, metal } = kSteel;
    const whole = { ...frame, plane: undefined };
    if (glass) this.use("glass", whole, { model, tint: [...screenColor(kGlassColor), kGlassEdge] });
    else this.use("full", whole, { roughness, metal, model, palette: linearColor(color) }, "TISSUE");
  }
  ghost(frame: Frame, tint: readonly number[]): void {
    this.use("ghost", frame, { tint });
  }
  // Without a colour.
  count(frame: Frame): void {
    this.use("count", frame, {});
  }
  stripes(tint: readonly number[], width: number): void {
    this.program("stripes").use({ tint, width });
  }
  // In one colour (`tint`), where `model` puts it.
  plain({ view, projection }: Frame): Program {
    const program = this.program("plain");
    program.use({ view, projection, model: kUnmoved, dash: 0 });
    return program;
  }

  private use(kind: Kind, frame: Frame, more: Readonly<Record<string, Uniform>>, ...defines: readonly string[]): void {
    const { plane, toSlice, ...matrices } = frame;
    const program = this.program(kind, plane === undefined ? defines : [...defines, "CUT"]);
    program.use({ ...matrices, model: kUnmoved, wayTo: lampWays(frame.view), ...more });
    if (plane !== undefined) program.use({ plane, toSlice });
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.scale);
  }
  private program(kind: Kind, defines: readonly string[] = []): Program {
    const key = [kind, ...defines].join(" ");
    const known = this.programs.get(key);
    if (known !== undefined) return known;
    const made = this.make(kind, defines);
    this.programs.set(key, made);
    return made;
  }
  private make(kind: Kind, defines: readonly string[]): Program {
    const shift = (mm: number) => [...defines, `SHIFT ${mm.toFixed(4)}`];
    switch (kind) {
      case "full":
        return new Program(this.gl, kFullVertex, kFullFragment, defines);
      case "glass":
        return new Program(this.gl, kFullVertex, kGlassFragment, defines);
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
