import assert from "node:assert/strict";
import { test } from "node:test";
import { toScene } from "../../api/tooth_number";
import { kStillSides, stillPlane } from "./still_planes";

test("every side faces the eye, with its up in the picture, whichever way the tooth lies", () => {
  for (const anatomy of [
    { mesial: 1, up: "occlusal" },
    { mesial: -1, up: "occlusal" },
    { mesial: 1, up: "buccal" },
    { mesial: -1, up: "buccal" },
  ] as const)
    for (const { side, towards, up } of kStillSides) {
      const { right, up: along, against } = stillPlane(anatomy, towards, up);
      const way = (axis: number, other: boolean | undefined) =>
        [0, 1, 2].map((each) => (each === axis ? (other === true ? -1 : 1) : 0)) as [number, number, number];
      const [r, u] = [way(right, against?.[0]), way(along, against?.[1])];
      const eye = [r[1] * u[2] - r[2] * u[1], r[2] * u[0] - r[0] * u[2], r[0] * u[1] - r[1] * u[0]];
      const same = (a: readonly number[], b: readonly number[]) => a.every((part, i) => part - b[i]! === 0);
      assert.ok(same(eye, toScene(anatomy, towards)), `${side}, ${JSON.stringify(anatomy)}: ${eye}`);
      assert.ok(same(u, toScene(anatomy, up)), side);
    }
});
