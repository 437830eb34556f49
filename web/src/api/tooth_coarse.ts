import type { BlockMesh } from "./tooth_mesh";

// Fewer triangles for what is not cut: the vertices of each cube of kStride cells become one, at
// their mean (vertex clustering: Rossignac and Borrel, "Multi-resolution 3D approximations for
// rendering complex scenes", 1993). On a surface of radius R that is off by about (kStride ·
// voxel)² / 8 R: 11 µm at 0.05 mm and 1 mm. Vertices that a block shares with its neighbours stay
// as they are, so that no gap opens, whether the neighbour is coarse or not.

const kStride = 6;

// `cellOf`: of each vertex, in a block of `side`³ cells, x fastest; the outer layers are shared.
export function coarsened(
  { positionMm, normal, tissue, deviation, triangle }: BlockMesh,
  cellOf: Int32Array,
  side: number,
): BlockMesh {
  const cubes = Math.ceil(side / kStride);
  const representative = new Int32Array(cubes ** 3).fill(-1);
  const becomes = new Int32Array(tissue.length);
  const position: number[] = [];
  const count: number[] = [];
  const direction: number[] = [];
  const kept: number[] = []; // the vertex whose tissue and deviation it has
  for (let v = 0; v < tissue.length; ++v) {
    const cell = cellOf[v]!;
    const [x, y, z] = [cell % side, Math.floor(cell / side) % side, Math.floor(cell / (side * side))];
    const shared = x === 0 || y === 0 || z === 0 || x === side - 1 || y === side - 1 || z === side - 1;
    const cube = (Math.floor(z / kStride) * cubes + Math.floor(y / kStride)) * cubes + Math.floor(x / kStride);
    let to = shared ? -1 : representative[cube]!;
    if (to < 0) {
      to = kept.length;
      kept.push(v);
      count.push(0);
      position.push(0, 0, 0);
      direction.push(0, 0, 0);
      if (!shared) representative[cube] = to;
    }
    becomes[v] = to;
    ++count[to]!;
    for (let axis = 0; axis < 3; ++axis) {
      position[3 * to + axis]! += positionMm[3 * v + axis]!;
      direction[3 * to + axis]! += normal[4 * v + axis]!;
    }
  }
  const corners: number[] = [];
  for (let t = 0; t < triangle.length; t += 3) {
    const [a, b, c] = [becomes[triangle[t]!]!, becomes[triangle[t + 1]!]!, becomes[triangle[t + 2]!]!];
    if (a !== b && b !== c && c !== a) corners.push(a, b, c);
  }
  const out = {
    positionMm: Float32Array.from(position, (sum, i) => sum / count[Math.floor(i / 3)]!),
    normal: new Int8Array(4 * kept.length),
    tissue: Uint8Array.from(kept, (v) => tissue[v]!),
    deviation:
      deviation === undefined
        ? undefined
        : Float32Array.from({ length: 2 * kept.length }, (_, i) => deviation[2 * kept[i >> 1]! + (i & 1)]!),
    triangle: Uint16Array.from(corners),
  };
  for (let v = 0; v < kept.length; ++v) {
    const [x, y, z] = [direction[3 * v]!, direction[3 * v + 1]!, direction[3 * v + 2]!];
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    out.normal.set(
      [Math.round((127 * x) / length), Math.round((127 * y) / length), Math.round((127 * z) / length)],
      4 * v,
    );
  }
  return out;
}

// Several as one: each is drawn at a cost of its own, however small it is.
export function merged(meshes: readonly BlockMesh[]): BlockMesh {
  const sum = (of: (mesh: BlockMesh) => number) => meshes.reduce((total, mesh) => total + of(mesh), 0);
  const vertices = sum((mesh) => mesh.tissue.length);
  const compared = meshes.some((mesh) => mesh.deviation !== undefined);
  const out = {
    positionMm: new Float32Array(3 * vertices),
    normal: new Int8Array(4 * vertices),
    tissue: new Uint8Array(vertices),
    deviation: compared ? new Float32Array(2 * vertices) : undefined,
    triangle: new Uint32Array(sum((mesh) => mesh.triangle.length)),
  };
  let first = 0;
  let at = 0;
  for (const mesh of meshes) {
    out.positionMm.set(mesh.positionMm, 3 * first);
    out.normal.set(mesh.normal, 4 * first);
    out.tissue.set(mesh.tissue, first);
    if (mesh.deviation !== undefined) out.deviation?.set(mesh.deviation, 2 * first);
    for (const corner of mesh.triangle) out.triangle[at++] = first + corner;
    first += mesh.tissue.length;
  }
  return out;
}
