import assert from "node:assert/strict";
import { test } from "node:test";
import { homePath, navigation, parseRoute } from "./routes";

const route = (path: string) => parseRoute(new URL(path, "http://page.test"));

test("each address of the page leads to its screen", () => {
  assert.equal(route("/").name, "home");
  for (const [path, name] of [
    ["/exercises", "exercises"],
    ["/exercises/e1", "exercise"],
    ["/attempts", "attempts"],
    ["/attempts/a1/", "attempt"],
    ["/assignments/x", "assignment"],
    ["/cohorts/c", "cohort"],
    ["/people/p", "person"],
    ["/roster", "roster"],
    ["/account", "account"],
    ["/profiles/omega_6", "profile"],
    ["/live/a1", "watch"],
    ["/stations", "stations"],
    ["/grading", "grading"],
    ["/editor?exercise=e1", "editor"],
    ["/jobs", "jobs"],
    ["/audit", "audit"],
    ["/health", "health"],
  ] as const)
    assert.equal(route(path).name, name, path);
  assert.deepEqual(route("/attempts/a1"), { name: "attempt", id: "a1" });
});

test("a list keeps what it is narrowed to", () => {
  const attempts = route("/attempts?cohort=c1&state=scored");
  assert.ok(
    attempts.name === "attempts" && attempts.query.get("cohort") === "c1" && attempts.query.get("state") === "scored",
  );
});

test("addresses that do not exist are unknown and malformed escapes do not throw", () => {
  for (const path of [
    "/nothing",
    "/attempts/a1/more",
    "/audit/x",
    "/roster/x",
    "/stations/s1",
    "/toString",
    "/people/constructor/x",
  ])
    assert.equal(route(path).name, "unknown", path);
  assert.deepEqual(route("/attempts/%E0%A4%A"), { name: "attempt", id: "%E0%A4%A" });
});

test("every role begins at a place its navigation offers, everything offered exists, and only an admin is offered the audit", () => {
  for (const role of ["student", "instructor", "admin"] as const) {
    const paths = navigation(role).map((item) => item.path);
    assert.ok(paths.includes(homePath(role)));
    assert.equal(paths.includes("/audit"), role === "admin");
    for (const path of paths) assert.notEqual(route(path).name, "unknown", path);
  }
});
