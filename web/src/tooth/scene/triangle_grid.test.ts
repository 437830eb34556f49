import assert from "node:assert/strict";
import { test } from "node:test";
import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, Raycaster, Vector3 } from "three";
import { TriangleGrid } from "./triangle_grid";

// A bumpy ball of about 2 n^2 triangles.
function ball(n: number) {
  const position = new Float32Array(3 * (n + 1) * (n + 1));
  const index = new Uint32Array(6 * n * n);
  for (let j = 0; j <= n; ++j) {
    for (let i = 0; i <= n; ++i) {
      const [polar, azimuth] = [(Math.PI * j) / n, (2 * Math.PI * i) / n];
      const radius = 5 + 0.6 * Math.sin(9 * azimuth) * Math.sin(7 * polar);
      position.set(
        [
          radius * Math.sin(polar) * Math.cos(azimuth),
          radius * Math.sin(polar) * Math.sin(azimuth),
          radius * Math.cos(polar),
        ],
        3 * (j * (n + 1) + i),
      );
    }
  }
  for (let j = 0; j < n; ++j) {
    for (let i = 0; i < n; ++i) {
      const a = j * (n + 1) + i;
      index.set([a, a + 1, a + n + 1, a + 1, a + n + 2, a + n + 1], 6 * (j * n + i));
    }
  }
  return { position, index };
}

const towards = (from: Vector3, k: number) =>
  new Vector3(4.6 * Math.sin(3 * k), 4.6 * Math.cos(5 * k), 4.6 * Math.sin(7 * k)).sub(from).normalize();

test("the grid finds what looking at every triangle finds, from outside and from inside", () => {
  const { position, index } = ball(80);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(position, 3));
  geometry.setIndex(new BufferAttribute(index, 1));
  const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide }));
  const grid = new TriangleGrid(position, index);
  const raycaster = new Raycaster();
  let hits = 0;
  for (const from of [new Vector3(0.2, -0.3, 20), new Vector3(-14, 9, 3), new Vector3(0.1, 0.2, 0.3)]) {
    for (let k = 0; k < 150; ++k) {
      raycaster.set(from, towards(from, k));
      const [expected] = raycaster.intersectObject(mesh, false);
      const found = grid.firstHit(from.toArray(), raycaster.ray.direction.toArray());
      assert.equal(found === undefined, expected === undefined, `ray ${k} from ${from.toArray()}`);
      if (expected === undefined || found === undefined) continue;
      ++hits;
      assert.ok(expected.point.distanceTo(new Vector3(...found.at)) < 1e-4, `ray ${k}`);
    }
  }
  assert.ok(hits > 300, `${hits} hits`);
});

test("rays along an axis, past the surface, and away from it are answered", () => {
  const { position, index } = ball(40);
  const grid = new TriangleGrid(position, index);
  assert.ok(Math.abs((grid.firstHit([0.01, 0.02, 9], [0, 0, -1])?.at[2] ?? 0) - 5) < 0.1);
  assert.equal(grid.firstHit([20, 0, 9], [0, 0, -1]), undefined);
  assert.equal(grid.firstHit([0, 0, 9], [0, 0, 1]), undefined);
  assert.equal(new TriangleGrid(new Float32Array(0), new Uint32Array(0)).firstHit([0, 0, 1], [0, 0, -1]), undefined);
});
