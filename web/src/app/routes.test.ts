import assert from "node:assert/strict";
import { test } from "node:test";
import { homePath, navigation, parseRoute } from "./routes";

const route = (path: string) => parseRoute(new URL(path, "http://page.test"));

test("each address of the page leads to its screen", () => {
  assert.deepEqual(route("/"), { name: "home" });
  assert.deepEqual(route("/exercises"), { name: "exercises" });
  assert.deepEqual(route("/exercises/e1"), { name: "exercise", id: "e1" });
  assert.deepEqual(route("/attempts?cohort=c1"), { name: "attempts", cohort: "c1" });
  assert.deepEqual(route("/attempts/a1/"), { name: "attempt", id: "a1" });
  assert.deepEqual(route("/audit"), { name: "audit" });
});

test("addresses that do not exist are unknown and malformed escapes do not throw", () => {
  assert.deepEqual(route("/nothing"), { name: "unknown" });
  assert.deepEqual(route("/attempts/a1/more"), { name: "unknown" });
  assert.deepEqual(route("/audit/x"), { name: "unknown" });
  assert.deepEqual(route("/attempts/%E0%A4%A"), { name: "attempt", id: "%E0%A4%A" });
});

test("every role begins at a place its navigation offers, and only an admin is offered the audit", () => {
  for (const role of ["student", "instructor", "admin"] as const) {
    const paths = navigation(role).map((item) => item.path);
    assert.ok(paths.includes(homePath(role)));
    assert.equal(paths.includes("/audit"), role === "admin");
  }
});
