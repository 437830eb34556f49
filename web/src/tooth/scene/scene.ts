import { Disposables } from "../../base/disposables";
import { FrameScheduler } from "../../base/frame";
import type { Look } from "../../base/moment_link";
import type { Film, FilmScreen, Placed } from "../film";
import type { CameraPreset, Detail, Extent, PointMm, ScreenState, ScreenTold, SurfacePoint } from "../messages";
import type { Opened } from "../opened";
import type { BlockMesh } from "../mesher";
import type { Outline } from "../timeline";
import { type BlockHit, boxOf, ToothBlocks } from "./blocks";
import type { CutFill } from "./cut_fill";
import { screenColor } from "./colors";
import { ForceArrow } from "./force_arrow";
import { Ghost, kMarking } from "./ghost";
import { beginPicture, drawOver, type Gl, type Program, Shape } from "./gl";
import { kTargetColor } from "../line_colors";
import { LineGroup } from "./line_group";
import type { Frame, Paint } from "./paint";
import { DrawingPace, drawsSlowly, pixelRatio } from "./renderer";
import { type Cuttable, normalOf, Section } from "./section";
import { Sight } from "./sight";
import { ball, revolved } from "./solids";
import { add, dot, kUnmoved, kUnturned, type Matrix, placed, scaled, sub, turnBetween, unit, type Vec } from "./vec";

const kMinRadiusMm = 0.5;
// The tool's mark, and its rim.
const kMarks = [
  { color: "#ffffff", radiusMm: 0.29 },
  { color: "#0b7a4b", radiusMm: 0.2 },
] as const;
const kMarkShare = 0.33; // of half the picture's height, per mm: a mark does not cover a place that is seen from near
const kNowhere = [0, 0, 0, 0, 0, 0, 0, 0, 0];
const kTrailTint = [...screenColor("#101418"), 0.55];

// What the page tells after it has asked for another moment. In motion it is drawn with the next picture, or with the
// one in full: a picture of its own would be a second one of each moment.
const kWithMoment: ReadonlySet<string> = new Set(["tool", "path", "forceN"] satisfies (keyof ScreenState)[]);

type Drawn = Extract<ScreenTold, { told: "drawn" }>;

// A picture of a tooth: draws only when something changed.
export class ToothScene implements FilmScreen {
  wishes = 0; // that the next picture fulfils
  readonly sight: Sight;
  private readonly canvas: OffscreenCanvas;
  private readonly gl: Gl;
  private readonly cleanup = new Disposables();
  private readonly frame = new FrameScheduler(() => this.draw());
  private readonly blocks: ToothBlocks;
  private readonly mark: Shape;
  private tool: PointMm | undefined;
  private readonly burs = new Map<Outline, Shape>();
  private bur: Placed | undefined; // that cuts
  private glass: Placed | undefined; // that has cut
  private trail: Shape | undefined;
  private readonly arrow: ForceArrow;
  private readonly lines: LineGroup;
  private readonly pace: DrawingPace;
  private readonly section: Section;
  private fill: CutFill | undefined;
  private readonly targetCut: Section;
  private target: readonly Cuttable[] = [];
  private ghost: { readonly drawn: Ghost; readonly end: () => void } | undefined;
  private follows = false; // the camera stays at the bur
  private detail: Detail = "none";
  private extent: Extent = { centreMm: [0, 0, 0], radiusMm: 1 };
  private size = { width: 0, height: 0, ratio: 1 };

  constructor(
    private readonly paint: Paint, // its own from now on
    state: ScreenState,
    private readonly drawn: (drawn: Drawn) => void,
    rests: () => void, // called when nothing has moved for a while
  ) {
    const { canvas, gl } = paint;
    this.canvas = canvas;
    this.gl = gl;
    this.cleanup.add(() => gl.getExtension("WEBGL_lose_context")?.loseContext());
    const kept = <T extends { dispose(): void }>(made: T): T => {
      this.cleanup.add(() => made.dispose());
      return made;
    };
    kept(paint);
    this.blocks = kept(new ToothBlocks(gl));
    this.section = kept(new Section(gl));
    this.cleanup.add(() => this.fill?.dispose());
    this.targetCut = kept(new Section(gl, kTargetColor));
    this.arrow = kept(new ForceArrow(gl));
    this.lines = kept(new LineGroup(gl));
    this.mark = kept(ball(gl));
    this.pace = new DrawingPace(drawsSlowly(), () => this.draw(), rests);
    this.cleanup.add(() => this.pace.stop());
    this.cleanup.add(() => this.endGhost());
    this.cleanup.add(() => this.trail?.dispose());
    this.cleanup.add(() => {
      for (const bur of this.burs.values()) bur.dispose();
    });
    this.sight = new Sight(state.angled, () => this.frame.request());
    this.cleanup.add(() => this.frame.cancel());
  }

  dispose(): void {
    this.cleanup.dispose();
  }

  // `film`: gives the one of a number.
  set(state: Partial<ScreenState>, film: (ghost: number) => Film | undefined): void {
    if (state.mode !== undefined) this.paint.heat = state.mode === "deviation";
    if (state.angled !== undefined) this.sight.setAngled(state.angled);
    if (state.anatomy !== undefined) this.sight.setAnatomy(state.anatomy);
    if ("tool" in state || "path" in state) this.setTool(state.tool, state.path ?? []);
    if ("forceN" in state) this.arrow.set(state.forceN);
    if ("lines" in state) this.lines.set(state.lines);
    if ("section" in state) this.setSection(state.section);
    if ("target" in state) this.setTarget(state.target);
    if ("ghost" in state) this.setGhost(state.ghost === undefined ? undefined : film(state.ghost));
    if (state.follow !== undefined) this.setFollow(state.follow);
    if (this.pace.effort === "full" || Object.keys(state).some((name) => !kWithMoment.has(name))) this.frame.request();
  }

  private setTool(point: PointMm | undefined, path: readonly PointMm[]): void {
    this.tool = point;
    this.trail?.dispose();
    this.trail =
      path.length < 2
        ? undefined
        : new Shape(
            this.gl,
            { position: { data: Float32Array.from(path.flat()), size: 3 } },
            undefined,
            this.gl.LINE_STRIP,
          );
  }

  setDetail(detail: Detail, extent: Extent): void {
    this.detail = detail;
    this.moved();
    if (extent === this.extent) return;
    this.extent = { ...extent, radiusMm: Math.max(extent.radiusMm, kMinRadiusMm) };
    this.sight.setExtent(this.extent);
  }
  expect(): void {
    this.pace.moved();
  }
  setBlock(index: number, mesh: BlockMesh | undefined): void {
    this.blocks.set(index, mesh);
    this.paint.translucent = false; // part of it alone would be a patchwork
    this.section.changed();
    // Blocks come by dozens, and a timer set anew takes as long as a block's lines.
    if (!this.frame.requested) this.moved();
  }
  setLooks(looks: (mesh: BlockMesh) => Uint8Array<ArrayBuffer> | undefined): void {
    if (this.paint.translucent) return;
    this.blocks.setLooks(looks);
    this.paint.translucent = true;
    this.frame.request();
  }
  setOpened(opened: Opened): void {
    this.fill?.dispose();
    this.fill = opened.fill(this.gl);
    this.frame.request();
  }
  private setTarget(body: ScreenState["target"]): void {
    this.target = body === undefined ? [] : [{ mesh: body, box: boxOf(body.positionMm) }];
    this.targetCut.changed();
  }
  setBur(bur: Placed | undefined): void {
    if (bur === this.bur) return;
    this.bur = bur;
    if (this.follows) this.follow();
    this.moved();
  }
  // Over the finished tooth, whose colours stay as they are under it.
  setGlass(bur: Placed | undefined): void {
    this.glass = bur;
    this.frame.request();
  }
  // What is drawn, and where.
  private solid({ outline, pose }: Placed): readonly [Shape, Matrix] {
    const shape = this.burs.get(outline) ?? revolved(this.gl, outline);
    this.burs.set(outline, shape);
    return [shape, placed(turnBetween([0, 0, 1], unit(pose.axis)), pose.tipMm)];
  }

  // Another tooth over this one, translucent; undefined: none. It can neither be pointed at nor
  // does it change what is framed.
  private setGhost(film: Film | undefined): void {
    this.endGhost();
    if (film !== undefined) {
      const drawn = new Ghost(
        this.gl,
        () => this.pace.moved(),
        () => this.moved(),
      );
      this.ghost = { drawn, end: film.attach(drawn) };
      drawn.section.set(this.section.wanted);
    }
  }
  private endGhost(): void {
    if (this.ghost === undefined) return;
    const { drawn, end } = this.ghost;
    this.ghost = undefined;
    end();
    drawn.dispose();
  }

  // Undefined: none. The hidden part cannot be pointed at either.
  private setSection(plane: ScreenState["section"]): void {
    const was = this.section.wanted;
    this.section.set(plane);
    this.targetCut.set(plane);
    this.ghost?.drawn.section.set(plane);
    // Seen from aside a cut is a line.
    const turns = plane !== undefined && plane.across !== "view";
    if (turns && (plane.across !== was?.across || plane.flipped !== was.flipped)) this.sight.face(normalOf(plane));
  }
  private setFollow(on: boolean): void {
    this.follows = on;
    if (on) this.follow();
  }
  private follow(): void {
    if (this.bur !== undefined) this.sight.follow(this.bur.pose.tipMm);
  }

  // What lies over the picture has moved without it.
  redraw(): void {
    this.frame.request();
  }
  // More motion is likely to follow at once.
  moved(): void {
    this.pace.moved(this.detail !== "fine");
    this.frame.request();
  }
  settle(): void {
    this.pace.settle();
  }

  // CSS pixels, and how many of the screen's each has.
  resize(width: number, height: number, ratio: number): void {
    if (width < 1 || height < 1) return;
    this.size = { width, height, ratio };
    this.sight.resize(width, height);
    this.frame.request();
  }

  // What is under a point of the picture, in CSS pixels from its top left corner.
  pick(x: number, y: number): SurfacePoint | undefined {
    const { width, height } = this.size;
    return this.firstSeen(this.sight.eye, this.sight.wayThrough((2 * x) / width - 1, 1 - (2 * y) / height));
  }
  private firstSeen(eye: Vec, way: Vec): SurfacePoint | undefined {
    const { section } = this;
    const hit = this.blocks.firstHit(eye, way, (at) => section.isShown(at));
    if (hit === undefined) return undefined;
    const planeMm = section.on ? section.meets(eye, way) : undefined;
    // The inside of the surface stands for the cut.
    if (planeMm !== undefined && dot(normalAt(hit), way) > 0)
      return { tissue: this.fill?.tissueAt(planeMm), deviationMm: undefined, pointMm: planeMm, planeMm };
    return { ...pointOf(hit), planeMm };
  }

  // How far the surface is from the line between two points towards the eye, at even steps of it: what one sees first
  // along the line of sight. NaN: nothing there.
  profile(from: PointMm, to: PointMm, samples: number): Float32Array {
    const towards = unit(this.sight.away);
    const far = 4 * this.extent.radiusMm;
    return Float32Array.from({ length: samples }, (_, i) => {
      const on = add(from, scaled(sub(to, from), i / (samples - 1)));
      const seen = this.firstSeen(add(on, scaled(towards, far)), scaled(towards, -1));
      return seen === undefined ? Number.NaN : dot(sub(seen.pointMm, on), towards);
    });
  }

  // PNG. It is looked at as before afterwards.
  picture(preset: CameraPreset): Promise<Blob> {
    const before = this.sight.look();
    this.sight.view(preset);
    this.pace.settle();
    this.drawNow();
    const made = this.canvas.convertToBlob({ type: "image/png" });
    this.look(before);
    return made;
  }

  drawNow(): void {
    this.frame.cancel();
    this.draw();
  }
  private draw(): void {
    const { gl, sight } = this;
    if (this.size.width < 1 || this.detail === "none" || gl.isContextLost()) return;
    const { centreMm, radiusMm } = sight.cutOpen;
    const { section } = this;
    section.update(centreMm, radiusMm, sight.away, () => this.blocks.meshes());
    this.targetCut.update(centreMm, radiusMm, sight.away, () => this.target);
    this.ghost?.drawn.section.update(centreMm, radiusMm, sight.away, this.ghost.drawn.parts);
    this.fit();
    const picture = sight.picture;
    this.drawFrame({
      view: sight.fromScene,
      projection: sight.projection,
      picture,
      ...this.cut(),
    });
    this.drawn({
      told: "drawn",
      wishes: this.wishes,
      effort: this.pace.effort,
      detail: this.detail,
      projection: picture,
      look: sight.look(),
      middle: section.on ? section.meets(sight.eye, scaled(sight.away, -1)) : sight.target,
      extent: this.extent,
    });
  }
  // Of the section, when the picture has its size.
  private cut(): Pick<Frame, "plane" | "toSlice"> {
    const { section, sight, canvas } = this;
    if (!section.on) return { plane: undefined, toSlice: kNowhere };
    const way = (right: number, up: number) => sight.wayThrough(right, up);
    const rows = this.fill?.update(section.plane, this.extent, sight.eye, way, [canvas.width, canvas.height]);
    return { plane: section.plane, toSlice: rows ?? kNowhere };
  }
  // As many pixels as the effort asks for.
  private fit(): void {
    const ratio = pixelRatio(this.pace.effort, this.size.ratio);
    const [width, height] = [Math.floor(this.size.width * ratio), Math.floor(this.size.height * ratio)];
    if (this.canvas.width === width && this.canvas.height === height) return;
    this.canvas.width = width;
    this.canvas.height = height;
    this.gl.viewport(0, 0, width, height);
  }
  private drawFrame(frame: Frame): void {
    const { gl, paint, ghost } = this;
    beginPicture(gl);
    paint.tooth(this.pace.effort, frame);
    // Behind a section's plane one looks at the inside of the surface: painted flat it is the cut.
    drawOver(gl, {
      faces: frame.plane === undefined ? "front" : "both",
      stencil: ghost === undefined ? undefined : kMarking,
    });
    this.blocks.draw(frame.picture);
    ghost?.drawn.draw(paint, frame);
    const bur = this.bur ?? this.glass;
    if (bur !== undefined) {
      const [shape, model] = this.solid(bur);
      const glass = bur === this.glass;
      paint.bur(frame, model, glass);
      drawOver(gl, { hides: !glass, mixed: glass });
      shape.draw();
    }
    this.drawOnTop(paint.plain(frame), frame.projection);
  }
  // What is seen through the tooth.
  private drawOnTop(plain: Program, projection: Matrix): void {
    const { gl, tool, sight } = this;
    const bur = this.bur ?? this.glass;
    drawOver(gl, { depth: false, mixed: true });
    plain.set("tint", kTrailTint);
    this.trail?.draw();
    this.lines.draw(plain);
    drawOver(gl, { depth: false });
    for (const { color, radiusMm } of tool === undefined || bur !== undefined ? [] : kMarks) {
      plain.set("tint", [...screenColor(color), 1]);
      const size = radiusMm * Math.min(1, kMarkShare * sight.halfHighMm);
      plain.set("model", placed(kUnturned, tool!, [size, size, size]));
      this.mark.draw();
    }
    plain.set("model", kUnmoved);
    for (const cut of [this.ghost?.drawn.section, this.targetCut, this.section]) cut?.draw(plain, projection);
    // At the bur or, where none is shown, at the tool's mark.
    this.arrow.draw(plain, bur?.pose.tipMm ?? tool, sight.halfHighMm);
  }

  look(look: Look): void {
    this.sight.setLook(look);
    this.frame.request();
  }
}

function normalAt({ mesh: { normal }, vertex }: BlockHit): Vec {
  return [normal[4 * vertex]!, normal[4 * vertex + 1]!, normal[4 * vertex + 2]!];
}

// A place whose deviation is not known looks untouched.
function pointOf(hit: BlockHit): Omit<SurfacePoint, "planeMm"> {
  const {
    mesh: { tissue, deviation },
    vertex,
    at,
  } = hit;
  const deviationMm =
    deviation === undefined ? undefined : deviation[2 * vertex + 1] === 0 ? Number.NaN : deviation[2 * vertex];
  return { tissue: tissue[vertex] ?? 0, deviationMm, pointMm: at };
}
