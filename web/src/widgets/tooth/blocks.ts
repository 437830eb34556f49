import { Box3, BufferAttribute, BufferGeometry, Group, type Material, Mesh, Ray, Vector3 } from "three";
import type { BlockMesh } from "../../api/tooth_mesh";
import { tissueColors } from "./tissue_colors";
import { TriangleGrid } from "./triangle_grid";

// A tooth in blocks, each with its own triangles, so that only cut blocks go to the graphics card
// again.

const kCellsAlong = 16; // of a block, which has a few thousand triangles

export interface BlockHit {
  readonly mesh: BlockMesh;
  readonly vertex: number; // of the triangle that is met
  readonly at: readonly [number, number, number];
}

interface Block {
  readonly mesh: BlockMesh;
  readonly drawn: Mesh;
  readonly box: Box3;
  grid: TriangleGrid | undefined; // made when a ray first comes near
}

export class ToothBlocks {
  readonly group = new Group();
  private readonly blocks = new Map<number, Block>();

  // Of several materials each draws every block.
  constructor(private material: Material | Material[]) {}

  // All are drawn with it from now on.
  use(material: Material): void {
    this.material = material;
    for (const { drawn } of this.blocks.values()) drawn.material = material;
  }

  dispose(): void {
    for (const { drawn } of this.blocks.values()) drawn.geometry.dispose();
    this.blocks.clear();
  }

  set(index: number, mesh: BlockMesh | undefined): void {
    const before = this.blocks.get(index);
    if (before !== undefined) {
      this.group.remove(before.drawn);
      before.drawn.geometry.dispose();
      this.blocks.delete(index);
    }
    if (mesh === undefined) return;
    const geometry = blockGeometry(mesh);
    if (Array.isArray(this.material)) for (const i of this.material.keys()) geometry.addGroup(0, Infinity, i);
    const drawn = new Mesh(geometry, this.material);
    // Nothing here moves: three need not look at each block's place at every frame.
    drawn.matrixAutoUpdate = false;
    this.blocks.set(index, { mesh, drawn, box: geometry.boundingBox ?? new Box3(), grid: undefined });
    this.group.add(drawn);
  }

  meshes(): Iterable<{ readonly mesh: BlockMesh; readonly box: Box3 }> {
    return this.blocks.values();
  }

  // What a ray meets first. `direction` need not have the length 1.
  firstHit(
    origin: Vector3,
    direction: Vector3,
    meets: (point: readonly [number, number, number]) => boolean,
  ): BlockHit | undefined {
    const ray = new Ray(origin, direction.clone().normalize());
    const entry = new Vector3();
    const near = [...this.blocks.values()]
      .flatMap((block) => {
        if (ray.intersectBox(block.box, entry) === null) return [];
        return [{ block, from: block.box.containsPoint(origin) ? 0 : entry.distanceTo(origin) }];
      })
      .sort((a, b) => a.from - b.from);
    let best: BlockHit | undefined;
    let nearest = Infinity;
    for (const { block, from } of near) {
      if (from > nearest) break;
      block.grid ??= new TriangleGrid(block.mesh.positionMm, block.mesh.triangle, kCellsAlong);
      const hit = block.grid.firstHit(ray.origin.toArray(), ray.direction.toArray(), meets);
      if (hit === undefined) continue;
      const along = new Vector3(...hit.at).distanceTo(origin);
      if (along >= nearest) continue;
      nearest = along;
      best = { mesh: block.mesh, vertex: block.mesh.triangle[3 * hit.triangle]!, at: hit.at };
    }
    return best;
  }
}

function blockGeometry({ positionMm, normal, tissue, triangle, deviation }: BlockMesh): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positionMm, 3));
  geometry.setAttribute("normal", new BufferAttribute(normal, 4, true));
  geometry.setAttribute("color", new BufferAttribute(tissueColors(tissue), 3, true));
  if (deviation !== undefined) geometry.setAttribute("deviation", new BufferAttribute(deviation, 2));
  geometry.setIndex(new BufferAttribute(triangle, 1));
  geometry.computeBoundingBox();
  geometry.computeBoundingSphere();
  return geometry;
}
