// Attempts of the mock server: the actions on them, and the content of their recordings.
import { conflict, forbidden, refused, Reply } from "./contract.mjs";
import { kReference, scoreOf } from "./mock_exercises.mjs";
import { playbackOf, seriesEndS, toolPosition, toothSurface } from "./mock_tooth.mjs";
import { added, newId } from "./mock_world.mjs";

export const hidden = (row) => !row.released && (row.exam || row.exercise.graded);
const withheld = (row, { person }) => person.role === "student" && row.person === person && hidden(row);

export function attemptView(row, call) {
  const { person, world } = call;
  const student = person.role === "student";
  const unseen = withheld(row, call)
    ? { score: null, computed_score: null, critical_fail: null, override: null, appeal: null }
    : {};
  const near =
    !student && row.flags.includes("near_another")
      ? world.attempts.find((each) => each !== row && each.exercise === row.exercise && each.person !== row.person)
      : undefined;
  return {
    ...row,
    ...unseen,
    flags: student ? row.flags.filter((flag) => flag !== "near_another") : row.flags,
    duration_s: row.ticks / 1000,
    time_limit_s: 600,
    may: actionsOn(row, student),
    result_fingerprint: row.state === "scored" && !withheld(row, call) ? "3fa9c1d2".repeat(8) : null,
    reference: row.state === "scored" && !withheld(row, call) ? kReference : null,
    nearness:
      near === undefined
        ? null
        : {
            attempt_id: near.id,
            person: near.person,
            others: 12,
            nearest_mm: 0.018,
            median_mm: 0.94,
            size_mm: 1.32,
            worth_a_look: true,
            preset: { others: 2, nearest_mm: 0.71, worth_a_look: false },
          },
    sign_off:
      student || !row.exam
        ? null
        : {
            start: {
              by: world.people.find(({ role }) => role === "instructor").display_name,
              at_ms: row.ticketed_ms + 20_000,
            },
            end: null,
          },
    evidence:
      student || !row.exam || row.state !== "scored"
        ? null
        : {
            tremor_um: 1.25,
            least_tremor_um: 8,
            too_calm: true,
            still_percent: 31.5,
            late_percent: 0.02,
            gap_percent: 0,
            rank: 2,
            of: 24,
            sign_ins: [
              { at_ms: row.ticketed_ms - 60_000, via: `station ${row.station.name}` },
              { at_ms: row.ticketed_ms - 300_000, via: "page" },
            ],
          },
  };
}

function actionsOn(row, student) {
  const scored = row.state === "scored";
  const may = student
    ? { appeal: scored && row.released && row.appeal === null }
    : {
        release: scored && !row.released,
        unrelease: row.released,
        override: row.score !== null,
        annotate: true,
        rescore: row.sealed_ms > 0 && row.state !== "scoring",
        excuse: row.assignment_id !== null && !row.flags.includes("excused"),
        unexcuse: row.flags.includes("excused"),
        mark_reference: scored,
        answer_appeal: row.appeal?.state === "open",
      };
  return Object.keys(may).filter((action) => may[action]);
}

const scored = (rule) => (call) =>
  call.row.state !== "scored"
    ? conflict("The attempt is not scored yet.")
    : withheld(call.row, call)
      ? forbidden("The score is not released yet.")
      : rule(call);
const change =
  (changes) =>
  ({ row, ...call }) =>
    Object.assign(row, changes(row, call));

// One attempt begins slowly and then hurries: its share of the work is the share of the time raised
// to this.
const paceOf = ({ id }) => (id.endsWith("201") ? 1.5 : 1);

function bytesOf({ request }, bytes, cached) {
  const [, from, to] = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "") ?? [];
  const headers = cached ? { "Cache-Control": "private, max-age=31536000, immutable" } : {};
  return from === undefined
    ? new Reply(bytes, { headers })
    : new Reply(bytes.subarray(Number(from), Number(to) + 1), { status: 206, headers });
}

const kSteps = 1800,
  kStepTicks = 24,
  kHeldBackN = 1.3,
  kLateStep = 140;
const round = (value) => Math.round(value * 1000) / 1000;

function seriesOf({ row }) {
  let [removed, drift, seed] = [0, 0, 7];
  const random = () => {
    seed = (seed * 1664525 + 1013904223) >>> 0;
    return seed / 2 ** 32;
  };
  const steps = Array.from({ length: kSteps }, (_, i) => {
    const share = (i / (kSteps - 1)) ** paceOf(row);
    const contact = share > 0.03 && share < 0.97 && Math.sin(share * 44) > -0.82;
    drift = 0.96 * drift + 0.06 * (random() - 0.5);
    const mean = contact ? Math.max(0.05, 0.72 + 0.35 * Math.sin(share * 21) + 1.4 * drift) : 0.01;
    const most = mean * (1.1 + 0.35 * random());
    removed += contact ? (24.73 / (kSteps * 0.86)) * (0.7 + 0.6 * random()) : 0;
    const [x, y, z] = toolPosition(share);
    const tip = [x, y, contact ? z : z + 2.5].map(round);
    const lean = 0.5 * Math.sin(share * 30);
    return {
      t_s: (i * kStepTicks) / 1000,
      force_n: most,
      force_mean_n: mean,
      bound_n: 7.9,
      computed_n: most > kHeldBackN ? most + 0.4 : most,
      removed_mm3: removed,
      tip,
      late_ticks: i === kLateStep ? 3 : 0,
      vector: [most * Math.sin(lean), 0, most * Math.cos(lean)].map(round),
      pulp_mm: Math.min(5, Math.hypot(tip[0], tip[1], tip[2] + 4.5)),
    };
  });
  const all = (name, share = 1) => steps.map((step) => round(step[name] * share));
  return {
    rate_hz: 1000,
    step_ticks: kStepTicks,
    ...Object.fromEntries(
      ["t_s", "force_n", "force_mean_n", "bound_n", "computed_n", "removed_mm3", "late_ticks", "pulp_mm"].map(
        (name) => [name, all(name)],
      ),
    ),
    removed_by_tissue: { enamel: all("removed_mm3", 0.8), dentin: all("removed_mm3", 0.2) },
    anchor_mm: steps.map(({ tip }) => tip),
    force_vector_n: steps.map(({ vector }) => vector),
  };
}

// Ticks of the recording: a trembling force, held back at its peaks, and a gap of 50 ticks at each
// full second.
function ticksOf({ query: { from, to } }) {
  const times = Array.from({ length: Math.max(0, Math.min(to, 1000 * seriesEndS) - from) }, (_, i) => from + i).filter(
    (time) => time % 1000 >= 50,
  );
  const computed = times.map((time) => round(0.9 + 0.3 * Math.sin(time / 16) + 0.1 * Math.sin(time / 3)));
  return {
    from,
    to,
    time_ticks: times,
    computed_n: computed,
    force_n: computed.map((force) => Math.min(force, 1.2)),
    late: times.map(() => 0),
    limited: computed.map((force) => (force > 1.2 ? 1 : 0)),
  };
}

// Each look at an attempt that waits for its run, or is being scored, finds it further on.
function looked({ row }) {
  if (row.queued > 0 && --row.queued === 0) return Object.assign(row, { state: "scoring", progress: 0 });
  if (row.state !== "scoring") return row;
  row.progress = Math.min(1, row.progress + 0.25);
  return row.progress < 1
    ? row
    : Object.assign(row, {
        state: "scored",
        runs: row.score === null ? row.runs : row.runs + 1,
        score: row.override?.score ?? 80,
        computed_score: 80,
        critical_fail: false,
      });
}

function makeReference({ world, row, body }) {
  if (row.gap_ticks > 0 && body.anyway === undefined) {
    return conflict(
      "this attempt cannot be the reference: 4.1 % of its time is missing; choose another attempt, or give a reason why this one is right",
      "anyway",
    );
  }
  for (const other of world.attempts) other.is_reference = other === row;
  world.references.unshift({
    id: newId(world),
    exercise_id: row.exercise.id,
    attempt_id: row.id,
    ...body,
    version: world.references.length + 1,
    created_ms: world.nowMs,
    withdrawn_ms: 0,
  });
  return world.references[0];
}

function restore({ row, body: { run } }) {
  if (run > row.runs) return refused(404, "not_found", `There is no scoring run ${run}.`);
  return Object.assign(row, { state: "scored", queued: 0, progress: 1, runs: run === row.runs ? run : row.runs + 1 });
}

function runs({ row }) {
  return {
    results: Array.from({ length: row.runs }, (_, i) => ({
      run: row.runs - i,
      scored_ms: row.sealed_ms + (row.runs - i) * 60_000,
      cause: i === row.runs - 1 ? "seal" : "appeal",
      restorable: i === 1,
      score: scoreOf(row),
    })),
  };
}

// A run waits in the queue first; until it begins the attempt keeps its state.
const rescored = () => ({ queued: 3 });

// Server-sent events of a hand that circles in the tooth.
function live({ row, world }) {
  let tick = row.ticks + (world.nowMs % 1000);
  const rowAt = (at) => {
    const phase = at / 900;
    return [
      at,
      1800 * Math.cos(phase),
      1100 * Math.sin(phase),
      -400 - 250 * Math.sin(phase / 3),
      -300 * Math.cos(phase),
      -200 * Math.sin(phase),
      900 + 500 * Math.sin(phase * 1.7),
      16,
    ].map(Math.round);
  };
  const stream = (response) => {
    const timer = setInterval(() => {
      const rows = Array.from({ length: 8 }, (_, i) => rowAt(tick + 15 * (i + 1)));
      tick += 15 * rows.length;
      if (row.state === "recording")
        return void response.write(`event: ticks\ndata: ${JSON.stringify({ rows, tick })}\n\n`);
      clearInterval(timer);
      response.end("event: end\ndata: {}\n\n");
    }, 120);
    response.on("close", () => clearInterval(timer));
  };
  return row.state === "recording" ? new Reply(undefined, { stream }) : conflict("The attempt is not being made.");
}

// A box that is half a millimetre deeper at each look.
function liveCut({ row, query: { from = 0 } }) {
  if (row.state !== "recording") return conflict("The attempt is not being made.");
  const columns = Array.from({ length: 80 }, (_, i) => [(i % 10) - 5, Math.floor(i / 10) - 4, -500 - 500 * from, 0]);
  return { chunks: Math.min(from + 1, 6), cell_um: 250, columns: from < 6 ? columns : [] };
}

// The chair shows a remark from the second time that the page asks; `row.chair` overrides the state
// of its station.
function liveRemarks({ row: { said = [], chair = { connected: true, shows_remarks: true } } }) {
  for (const remark of said)
    Object.assign(
      remark,
      remark.state === "waiting" ? { state: "sent" } : { state: "shown", shown_ms: remark.sent_ms + 900 },
    );
  return { remarks: said, station: chair, allowed: true, max_characters: 500 };
}

function sayLive({ row, world, person, body: { text } }) {
  row.said ??= [];
  row.said.push({
    id: row.said.length + 1,
    text,
    from: person.display_name,
    sent_ms: world.nowMs,
    tick: 72_000,
    state: "waiting",
    shown_ms: null,
  });
  return row.said.at(-1);
}

export const attemptRules = {
  "GET /attempts/{id}": looked,
  "GET /attempts/{id}/score": scored(({ row }) => scoreOf(row)),
  "GET /attempts/{id}/ticks": scored(ticksOf),
  "GET /attempts/{id}/series": scored(seriesOf),
  "GET /attempts/{id}/surface": scored(() => new Reply(toothSurface())),
  "GET /attempts/{id}/timeline": scored((call) => bytesOf(call, playbackOf(paceOf(call.row)).timeline)),
  "GET /attempts/{id}/deviation": scored((call) => bytesOf(call, playbackOf().deviation)),
  "GET /start-teeth/{name}": (call) => bytesOf(call, playbackOf().start, true),
  "GET /attempts/{id}/results": scored(runs),
  "GET /attempts/{id}/live": live,
  "GET /attempts/{id}/live-cut": liveCut,
  "GET /live/{id}/remarks": liveRemarks,
  "POST /live/{id}/remarks": sayLive,
  "POST /attempts/{id}/annotations": (call) => ({
    ...added(call.world, call.world.annotations, {
      ...call.body,
      attempt_id: call.row.id,
      author: call.person,
      to_chair: false,
      edited_ms: 0,
    }),
    mine: true,
  }),
  "PUT /annotations/{id}": change((_row, { body, world }) => ({ ...body, edited_ms: world.nowMs })),
  "POST /attempts/{id}/release": change(() => ({ released: true })),
  "DELETE /attempts/{id}/release": change(() => ({ released: false })),
  "PUT /attempts/{id}/override": change((_row, { body, person, world }) => ({
    override: { ...body, by: person.display_name, at_ms: world.nowMs },
    score: body.score,
  })),
  "DELETE /attempts/{id}/override": change(({ computed_score }) => ({ override: null, score: computed_score })),
  "POST /attempts/{id}/rescore": change(rescored),
  "POST /attempts/{id}/excuse": change(({ flags }) => ({ flags: [...flags, "excused"] })),
  "DELETE /attempts/{id}/excuse": change(({ flags }) => ({ flags: flags.filter((flag) => flag !== "excused") })),
  "POST /attempts/{id}/restore-result": restore,
  "POST /attempts/{id}/reference": makeReference,
  "POST /attempts/{id}/appeal": change((_row, { body, world }) => ({
    appeal: { ...body, filed_ms: world.nowMs, state: "open", answer: "", answered_ms: 0 },
  })),
  "POST /attempts/{id}/appeal/answer": change((row, { body: { outcome, answer }, world }) => ({
    appeal: { ...row.appeal, state: outcome === "regrade" ? "regraded" : "rejected", answer, answered_ms: world.nowMs },
    ...(outcome === "regrade" ? rescored(row) : {}),
  })),
};
