import {
  AlwaysStencilFunc,
  BackSide,
  DecrementWrapStencilOp,
  EqualStencilFunc,
  FrontSide,
  Group,
  IncrementWrapStencilOp,
  type Material,
  Mesh,
  type Plane,
  PlaneGeometry,
  ReplaceStencilOp,
  ShaderMaterial,
} from "three";
import type { BlockMesh } from "../../api/tooth_mesh";
import { ToothBlocks } from "./blocks";
import type { FilmScreen } from "./film";
import { kGhostColor } from "./ghost_color";
import { asShown, kQuickVertex } from "./quick_material";
import { Section } from "./section";

// Another tooth over the one in view: translucent where it stands out of that one, and stripes on
// that one where the other has less left. Where both are the same nothing of it is seen, so that
// what was left untouched keeps its colours.
//
// Which places the other tooth does not reach is counted: along each line of sight, how often one
// goes into it and comes out again before it meets the tooth in view. Never, or as often out as in:
// that place is outside (as with shadow volumes: Heidmann, "Real shadows, real time", 1991). A
// section opens the other tooth, and this count with it: no stripes then.

const kSameMm = 0.03; // apart or less is the same: triangles of both are made coarser in other places
const kFill = 0.5; // opacities
const kStripe = 0.75;
const kStripePx = 7; // of the picture, from one stripe to the next
const kMarked = 128; // in the stencil: the tooth that is looked at, and neither in the other nor out of it

const kFragment = `
uniform vec3 tint;
varying float vLight;
#include <clipping_planes_pars_fragment>
void main() {
  #include <clipping_planes_fragment>
  gl_FragColor = vec4(tint * vLight, ${kFill.toFixed(2)});
}`;

const kStripeFragment = `
uniform vec3 tint;
void main() {
  if (fract((gl_FragCoord.x + gl_FragCoord.y) / ${kStripePx.toFixed(1)}) > 0.5) discard;
  gl_FragColor = vec4(tint, ${kStripe.toFixed(2)});
}`;

const shared = { transparent: true, depthWrite: false, uniforms: { tint: { value: asShown(kGhostColor) } } } as const;

// `shiftMm`: a little towards the side on which it counts as the same.
function surface(shiftMm: number, more: object = {}): ShaderMaterial {
  return new ShaderMaterial({
    vertexShader: kQuickVertex,
    fragmentShader: kFragment,
    vertexColors: true,
    clipping: true,
    defines: { SHIFT: shiftMm },
    ...shared,
    ...more,
  });
}
const counting = (side: typeof FrontSide | typeof BackSide) =>
  surface(kSameMm, {
    side,
    colorWrite: false,
    stencilWrite: true,
    stencilFunc: AlwaysStencilFunc,
    stencilZPass: side === FrontSide ? IncrementWrapStencilOp : DecrementWrapStencilOp,
  });

function stripes(): Mesh<PlaneGeometry, ShaderMaterial> {
  const mesh = new Mesh(
    new PlaneGeometry(2, 2),
    new ShaderMaterial({
      vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: kStripeFragment,
      depthTest: false,
      stencilWrite: true,
      stencilFunc: EqualStencilFunc,
      stencilRef: kMarked,
      ...shared,
    }),
  );
  mesh.frustumCulled = false;
  mesh.renderOrder = 0.25; // when all is counted, and before the bur
  return mesh;
}

// Whether what is drawn with it is marked for the count.
export function markBy(material: Material, on: boolean): void {
  material.stencilWrite = on;
  material.stencilRef = kMarked;
  material.stencilZPass = ReplaceStencilOp;
}

export class Ghost implements FilmScreen {
  readonly group = new Group();
  readonly section = new Section(kGhostColor);
  private readonly materials = [surface(-kSameMm), counting(FrontSide), counting(BackSide)];
  private readonly blocks = new ToothBlocks(this.materials);
  private readonly stripes = stripes();

  // `expected`: more of it comes soon; `changed`: asks for another drawing.
  constructor(
    private readonly expected: () => void,
    private readonly changed: () => void,
  ) {
    this.section.outline.renderOrder = 3.5; // below the line of the tooth that is looked at
    this.section.outline.renderOrder = 3.5; // below the line of the tooth that is looked at
    this.group.add(this.blocks.group, this.stripes, this.section.outline);
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
  // The visible bur belongs to the tooth in view.
  setBur(): void {}

  cutBy(plane: Plane | undefined): void {
    this.stripes.visible = plane === undefined;
    for (const material of this.materials) {
      material.clippingPlanes = plane === undefined ? null : [plane];
      material.needsUpdate = true;
    }
  }

  dispose(): void {
    this.blocks.dispose();
    this.section.dispose();
    this.stripes.geometry.dispose();
    for (const material of [...this.materials, this.stripes.material]) material.dispose();
  }
}
