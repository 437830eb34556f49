import assert from "node:assert/strict";
import { test } from "node:test";
import { troubles } from "../../api/trouble";
import type { ServerHealth } from "../../api/types";
import { budgetText, countText, findingsOf, perSecond, retentionText, shortTime } from "./health_text";

const kDayMs = 86_400_000;
const made = { at_ms: 99.5 * kDayMs, missing: 0, place: "/b/1", bytes: 5e6 };
const well: ServerHealth = {
  now_ms: 100 * kDayMs,
  started_ms: 99 * kDayMs,
  ingest: { takes_recordings: true, problem: "", waiting: "", chunks: 1000, chunk_bytes: 1e6, sealed: 10 },
  commits: { count: 500, failed: 0, timed: 500, p99_s: 0.02 },
  clock: { ahead_ms: 0, problem: "" },
  standby: "",
  disk: { free_bytes: 50e9, kept_free_bytes: 268e6, database_bytes: 1e6, log_bytes: 0 },
  jobs: { queued: 0, running: 0, failed: 0, counted_up_to: 200 },
  stations: { enrolled: 3, online: 3 },
  recordings: { open: 1, late: [] },
  sign_ins: { signed_in: 5, refused: 3, throttled: 0, busy: 0 },
  budgets: [],
  backup: made,
  backups: { folder: "/b", running: null, failed: null, drill: null },
  retention: [],
};
const titles = (health: ServerHealth) => findingsOf(health).map(({ tone, title }) => `${tone}: ${title}`);

test("a server that does well is said nothing of", () => {
  assert.deepEqual(findingsOf(well), []);
});

test("the navigation counts what is bad here", () => {
  const cases: Partial<ServerHealth>[] = [
    {},
    { ingest: { ...well.ingest, takes_recordings: false } },
    { clock: { ahead_ms: 9000, problem: "off" } },
    { standby: "missing" },
    { standby: "none" },
    { disk: { ...well.disk, free_bytes: 200e6 } },
    { disk: { ...well.disk, free_bytes: 400e6 } },
    { backup: { ...made, at_ms: 0, missing: 2 } },
    { backup: null, jobs: { ...well.jobs, failed: 3 } },
    { standby: "missing", clock: { ahead_ms: -9000, problem: "off" } },
  ];
  for (const changes of cases) {
    const health = { ...well, ...changes };
    assert.equal(
      troubles(health),
      findingsOf(health).filter(({ tone }) => tone === "bad").length,
      JSON.stringify(changes),
    );
  }
});

test("a restore drill that failed is shown with its reason", () => {
  const drill = { at_ms: 99 * kDayMs, place: "/b/1", problem: "1 file of the backup is missing" };
  const told = (problem: string) =>
    findingsOf({ ...well, backups: { ...well.backups, drill: { ...drill, problem } } }).map(({ text }) => text);
  assert.deepEqual(told(drill.problem), ["1 file of the backup is missing."]);
  assert.deepEqual(told(""), []);
});

test("a backup that failed is shown with its reason", () => {
  const failed = { at_ms: 99.9 * kDayMs, problem: "the backup disk is full" };
  assert.deepEqual(
    findingsOf({ ...well, backups: { ...well.backups, failed } }).map(({ title, text }) => [title, text]),
    [["The last backup failed", "The backup disk is full."]],
  );
});

test("problems that stop recordings come before warnings", () => {
  assert.deepEqual(
    titles({ ...well, backup: null, ingest: { ...well.ingest, takes_recordings: false, problem: "the disk is full" } }),
    ["bad: Recordings are not accepted", "warning: No backup has been made yet"],
  );
});

test("every figure that needs attention is reported", () => {
  const told = (changes: Partial<ServerHealth>) => titles({ ...well, ...changes });
  assert.deepEqual(told({ disk: { ...well.disk, free_bytes: 400e6 } }), ["warning: The disk is nearly full"]);
  assert.deepEqual(told({ disk: { ...well.disk, free_bytes: 200e6 } }), ["bad: The disk is nearly full"]);
  assert.deepEqual(told({ commits: { ...well.commits, p99_s: 0.9 } }), ["warning: Writes are slow"]);
  assert.deepEqual(told({ commits: { ...well.commits, failed: 1 } }), [
    "warning: 1 change could not be written since the server started",
  ]);
  assert.deepEqual(told({ jobs: { ...well.jobs, failed: 200 } }), ["warning: 200 or more jobs have failed"]);
  assert.deepEqual(told({ jobs: { ...well.jobs, queued: 60 } }), ["warning: 60 jobs are waiting"]);
  assert.deepEqual(told({ standby: "behind" }), ["warning: No synchronous standby"]);
  assert.deepEqual(told({ standby: "none" }), ["warning: No synchronous standby"]);
  assert.deepEqual(told({ standby: "missing", ingest: { ...well.ingest, waiting: "the database server waits" } }), [
    "bad: All changes are waiting for a standby",
  ]);
  assert.deepEqual(told({ standby: "synchronous" }), []);
  assert.deepEqual(told({ standby: "unknown" }), []);
  assert.deepEqual(told({ backup: { ...made, at_ms: 90 * kDayMs } }), ["warning: The last backup is 10 days old"]);
  assert.deepEqual(told({ backup: { ...made, at_ms: 99 * kDayMs, missing: 2 } }), [
    "bad: The last backup is missing 2 files",
  ]);
  assert.deepEqual(told({ sign_ins: { ...well.sign_ins, throttled: 20 } }), [
    "warning: 20 sign-ins were held back since the server started",
  ]);
  assert.deepEqual(told({ stations: { enrolled: 0, online: 0 } }), ["warning: No station is enrolled"]);
  assert.deepEqual(
    told({ recordings: { open: 2, late: [{ attempt_id: "a", station_id: "s", silent_ms: 150_000 }] } }),
    ["warning: No data from 1 attempt in progress"],
  );
  assert.deepEqual(told({ ingest: { ...well.ingest, waiting: "a person was erased" } }), [
    "warning: Changes are waiting",
  ]);
});

test("a wrong clock is reported with its direction", () => {
  const text = (ahead_ms: number) =>
    findingsOf({ ...well, clock: { ahead_ms, problem: "off" } }).map((finding) => finding.text);
  assert.deepEqual(text(8200), [
    "It is 8.2\u00a0s ahead of the database server’s clock. Set both machines to use the same time servers.",
  ]);
  assert.deepEqual(text(-8200), [
    "It is 8.2\u00a0s behind the database server’s clock. Set both machines to use the same time servers.",
  ]);
  assert.deepEqual(findingsOf({ ...well, clock: { ahead_ms: 4000, problem: "" } }), []);
});

test("a rising count is shown per second, and not across a restart", () => {
  const later = { ...well, now_ms: well.now_ms + 5000, ingest: { ...well.ingest, chunks: 1100 } };
  assert.equal(
    perSecond(well, later, (health) => health.ingest.chunks),
    20,
  );
  assert.equal(
    perSecond(well, { ...later, started_ms: later.now_ms }, (health) => health.ingest.chunks),
    undefined,
  );
  assert.equal(
    perSecond(undefined, later, (health) => health.ingest.chunks),
    undefined,
  );
});

test("counts that the server cuts off read as a lower bound, and retention rules are words", () => {
  assert.equal(countText(199, 200), "199");
  assert.equal(countText(200, 200), "200 or more");
  assert.deepEqual(retentionText({ what: "recordings", days: 730 }), ["Recordings", "deleted after 730 days"]);
  assert.equal(shortTime(0.0214), "21\u00a0ms");
  assert.equal(shortTime(0.0014), "1.4\u00a0ms");
});

test("a budget says who uses most of it and how often one wanted more", () => {
  const links = { budget: "station_links", unit: "count", limit: 8, most: 3, refused: 0 } as const;
  const chair = { kind: "station", id: "9f0c7f3e-0000-4000-8000-000000000001", name: "Chair 2" } as const;
  const cases = [
    [{ ...links, of: null, most: 0 }, "0 of 8"],
    [{ ...links, of: chair }, "3 of 8 (Chair 2)"],
    [{ ...links, of: chair, refused: 2 }, "3 of 8 (Chair 2), 2 times over"],
    [{ ...links, of: { kind: "address", id: null, name: "" } as const }, "3 of 8 (an address, see /metrics)"],
    [{ ...links, unit: "percent", limit: 50, most: 7, of: chair } as const, "7\u00a0% of 50\u00a0% (Chair 2)"],
    [
      { ...links, unit: "bytes", limit: 2 ** 25, most: 2 ** 19, of: chair } as const,
      "0.5\u00a0MiB of 32\u00a0MiB (Chair 2)",
    ],
  ] as const;
  for (const [budget, text] of cases) assert.deepEqual(budgetText(budget), ["Connections of a station", text]);
});
