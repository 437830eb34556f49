import type { BlockMesh } from "./mesher";
import { linearColor, palette } from "./scene/colors";
import { kTissues } from "./tissue_color";

// Triangles, normals and the tissues' colours as glTF 2.0 in one binary file (GLB; Khronos, "glTF 2.0 Specification",
// 2021). Lengths there are metres and +y is up: one node turns and scales the scene's millimetres with +z up.

const kMagic = 0x46546c67; // "glTF"
const kJson = 0x4e4f534a;
const kBin = 0x004e4942;
const kFloat = 5126;
const kUint = 5125;
const kByte = 5121;
const kArrays = 34962;
const kElements = 34963;
const kUp = [-Math.SQRT1_2, 0, 0, Math.SQRT1_2]; // quaternion: +z to +y
const kMetre = 0.001;

type Mesh = Pick<BlockMesh, "positionMm" | "normal" | "tissue" | "triangle">;

export function glbOf(meshes: readonly Mesh[]): ArrayBuffer {
  const vertices = meshes.reduce((sum, { tissue }) => sum + tissue.length, 0);
  const corners = meshes.reduce((sum, { triangle }) => sum + triangle.length, 0);
  const position = new Float32Array(3 * vertices);
  const normal = new Float32Array(3 * vertices);
  const color = new Uint8Array(4 * vertices);
  const index = new Uint32Array(corners);
  const shares = palette(linearColor); // COLOR_0 is linear
  const colors = Uint8Array.from({ length: 4 * kTissues }, (_, i) =>
    i % 4 === 3 ? 255 : Math.round(255 * shares[3 * Math.floor(i / 4) + (i % 4)]!),
  );
  let [vertex, corner] = [0, 0];
  for (const mesh of meshes) {
    position.set(mesh.positionMm, 3 * vertex);
    for (const [i, at] of mesh.triangle.entries()) index[corner + i] = at + vertex;
    for (const [i, tissue] of mesh.tissue.entries()) {
      normal.set(unit(mesh.normal, 4 * i), 3 * (vertex + i));
      color.set(colors.subarray(4 * tissue, 4 * tissue + 4), 4 * (vertex + i));
    }
    vertex += mesh.tissue.length;
    corner += mesh.triangle.length;
  }
  return file(
    [
      { array: position, type: "VEC3", component: kFloat, target: kArrays, ...boundsOf(position) },
      { array: normal, type: "VEC3", component: kFloat, target: kArrays },
      { array: color, type: "VEC4", component: kByte, target: kArrays, normalized: true },
      { array: index, type: "SCALAR", component: kUint, target: kElements },
    ],
    {
      asset: { version: "2.0", generator: "Enamel" },
      scene: 0,
      scenes: [{ nodes: [0] }],
      nodes: [{ name: "tooth", mesh: 0, rotation: kUp, scale: [kMetre, kMetre, kMetre] }],
      meshes: [
        {
          primitives: [{ attributes: { POSITION: 0, NORMAL: 1, COLOR_0: 2 }, indices: 3, material: 0 }],
        },
      ],
      materials: [{ pbrMetallicRoughness: { metallicFactor: 0, roughnessFactor: 0.5 } }],
    },
  );
}

interface Part {
  readonly array: Float32Array | Uint8Array | Uint32Array;
  readonly type: "SCALAR" | "VEC3" | "VEC4";
  readonly component: number;
  readonly target: number;
  readonly normalized?: boolean;
  readonly min?: readonly number[];
  readonly max?: readonly number[];
}

const kSizes = { SCALAR: 1, VEC3: 3, VEC4: 4 } as const;

// Every part has whole words, so that each begins where four divides.
function file(parts: readonly Part[], scene: object): ArrayBuffer {
  let at = 0;
  const views = parts.map(({ array, target }) => {
    const view = { buffer: 0, byteOffset: at, byteLength: array.byteLength, target };
    at += array.byteLength;
    return view;
  });
  const accessors = parts.map(({ array, type, component, normalized, min, max }, bufferView) => ({
    bufferView,
    componentType: component,
    count: array.length / kSizes[type],
    type,
    ...(normalized === true ? { normalized } : {}),
    ...(min === undefined ? {} : { min, max }),
  }));
  const text = JSON.stringify({ ...scene, buffers: [{ byteLength: at }], bufferViews: views, accessors });
  const json = new TextEncoder().encode(text.padEnd(text.length + ((4 - (text.length % 4)) % 4)));
  const bytes = new Uint8Array(28 + json.length + at);
  const view = new DataView(bytes.buffer);
  for (const [i, word] of [kMagic, 2, bytes.length, json.length, kJson].entries()) view.setUint32(4 * i, word, true);
  bytes.set(json, 20);
  view.setUint32(20 + json.length, at, true);
  view.setUint32(24 + json.length, kBin, true);
  for (const [i, { array }] of parts.entries())
    bytes.set(
      new Uint8Array(array.buffer, array.byteOffset, array.byteLength),
      28 + json.length + views[i]!.byteOffset,
    );
  return bytes.buffer;
}

// Of the bytes of a mesh's normals; glTF wants a length of 1.
function unit(normal: Int8Array, at: number): readonly number[] {
  const [x, y, z] = [normal[at]!, normal[at + 1]!, normal[at + 2]!];
  const length = Math.hypot(x, y, z);
  return length === 0 ? [0, 0, 1] : [x / length, y / length, z / length];
}

function boundsOf(position: Float32Array) {
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (const [i, value] of position.entries()) {
    min[i % 3] = Math.min(min[i % 3]!, value);
    max[i % 3] = Math.max(max[i % 3]!, value);
  }
  return position.length === 0 ? { min: [0, 0, 0], max: [0, 0, 0] } : { min, max };
}
