// Exercises, assignments and attempts of the mock server.
import { readFileSync } from "node:fs";
import { paceOf, referenceDetail, scoreOf, seriesEndS, seriesOf, ticksOf } from "./mock_data.mjs";
import { documentOf, lookAtExercise } from "./mock_editing.mjs";
import { assignmentInsight } from "./mock_insight.mjs";
import { mockPlayback } from "./mock_timeline.mjs";
import { conflict, edit, empty, forbidden, invalid, json, notFound, page, refusal, tagged, unseen } from "./mock_reply.mjs";
import { toothSurface } from "./mock_tooth.mjs";
import { newId } from "./mock_world.mjs";

const kScoringStep = 0.25;
const kLiveEventMs = 120;
const kRowsPerEvent = 8;

const byId = (rows, id) => rows.find((row) => row.id === id);
const teaches = (person) => person.role !== "student";

// Exercises

function summaryFor(world, person, exercise) {
  const { target: _target, rubric: _rubric, law: _law, rate_hz: _rate, handpiece: _handpiece, touch_cues: _cues, scene_sha256: _scene, document_sha256: _document, ...summary } = exercise;
  const owns = person.role === "admin" || exercise.owner?.id === person.id;
  const may = !teaches(person) ? [] : [...owns ? ["change"] : [], ...exercise.state === "published" && (owns || exercise.shared) ? ["assign"] : []];
  return { ...summary, owner: teaches(person) ? exercise.owner : null, may, my_attempts: world.attempts.filter((row) => row.exercise.id === exercise.id && row.person.id === person.id).length };
}

const wholeFor = (world, person, exercise) => ({ ...exercise, ...summaryFor(world, person, exercise) });

function listExercises({ world, person, query }) {
  const state = query.get("state");
  if (state !== null && !teaches(person)) return forbidden();
  const rows = world.exercises.filter((exercise) => exercise.state === (state ?? "published"));
  return json({ exercises: rows.map((exercise) => summaryFor(world, person, exercise)) });
}

function checkedDocument(world, body) {
  if (body?.format === undefined) return invalid("format", "expected 1 or 2, found nothing");
  if (body.rubric?.criteria?.length > 0 !== true) return invalid("rubric.criteria", "expected 1 to 64 criteria, found none");
  return { ...world.exercises[0], name: body.name, title: body.title, instructions: body.instructions ?? "", graded: body.graded === true };
}

function putDraft({ world, person, body, query }) {
  if (query.get("dry_run") === "true") return lookAtExercise(body);
  const checked = checkedDocument(world, body);
  if (checked.status !== undefined) return checked;
  if (world.exercises.some((row) => row.name === body.name && row.state === "draft")) return conflict("There is a draft of that name already: replace it.");
  const draft = { ...checked, id: newId(world), state: "draft", version: 0, revision: 1, has_reference: false, published_ms: world.nowMs,
                  owner: person.role === "admin" ? null : { id: person.id, display_name: person.display_name }, shared: person.role === "admin" };
  world.exercises.push(draft);
  documentOf(world, draft);
  if (body.format > 2) world.documents.set(draft.id, body);
  return tagged(wholeFor(world, person, draft), 201);
}

function changeDraft({ world, person, request, id }, change) {
  const exercise = byId(world.exercises, id);
  if (exercise === undefined) return notFound();
  return edit(request, exercise, (row) => wholeFor(world, person, row), change);
}

function replaceDraft(call) {
  const checked = checkedDocument(call.world, call.body);
  if (checked.status !== undefined) return checked;
  const { name, title, instructions, graded } = checked;
  if (call.body.format > 2) call.world.documents?.set(call.id, call.body);
  return changeDraft(call, (row) => void Object.assign(row, { name, title, instructions, graded }));
}

function deleteDraft(call) {
  const reply = changeDraft(call, () => undefined);
  if (reply.status !== 200) return reply;
  call.world.exercises = call.world.exercises.filter((row) => row.id !== call.id);
  return empty();
}

function versionsOf({ world, id }) {
  const { name } = byId(world.exercises, id);
  return json({ versions: world.exercises.filter((row) => row.name === name).map(({ id: own, title, version, state, document_sha256, published_ms }) =>
    ({ id: own, title, version, state, document_sha256, published_ms })) });
}

function share({ world, person, id, body }) {
  const row = byId(world.exercises, id);
  if (person.role !== "admin" && row.owner?.id !== person.id) return forbidden();
  if (body.shared !== undefined) row.shared = body.shared;
  return tagged(wholeFor(world, person, row));
}

// Assignments

const publishedOf = (world, name) => world.exercises.filter((item) => item.name === name && item.state === "published").sort((a, b) => b.version - a.version);

// As schema Grade says.
function gradeOf(world, assignment, person, attempts) {
  const made = attempts.filter((row) => row.assignment_id === assignment.id && row.person.id === person && !row.flags.includes("excused")).sort((a, b) => a.ticketed_ms - b.ticketed_ms);
  const scored = made.filter((row) => row.score !== null);
  const scores = scored.map((row) => row.score).sort((a, b) => a - b);
  const middle = scores.length >> 1;
  const mean = scores.reduce((sum, score) => sum + score, 0) / scores.length;
  const median = scores.length % 2 === 1 ? scores[middle] : (scores[middle - 1] + scores[middle]) / 2;
  const one = assignment.counting === "last" ? scored.at(-1) : scored.find((row) => row.score === scores.at(-1));
  const result = { best: one?.score, last: one?.score, mean, median }[assignment.counting];
  return { attempts: made.length, counted: scored.length, score: scored.length === 0 ? null : result,
           attempt_id: ["best", "last"].includes(assignment.counting) ? one?.id ?? null : null, released: scored.length > 0 && scored.every((row) => !isHidden(world, row)) };
}

function cohortGrades({ world, id }) {
  const cohort = byId(world.cohorts, id);
  const students = world.people.filter((person) => cohort.members.includes(person.id) && person.role === "student");
  const rows = world.assignments.filter((row) => row.cohort === id || row.cohort === null);
  const grades = students.map((person) => rows.map((row) => gradeOf(world, row, person.id, world.attempts)));
  return json({
    assignments: rows.map((row, i) => {
      const view = assignmentView(world, row, { id: "", role: "admin" });
      const scores = grades.map((each) => each[i].score).filter((score) => score !== null).sort((a, b) => a - b);
      const figures = scores.length === 0 ? { mean: null, median: null, lowest: null, highest: null }
        : { mean: scores.reduce((sum, score) => sum + score, 0) / scores.length, median: scores[scores.length >> 1], lowest: scores[0], highest: scores.at(-1) };
      return { id: row.id, exercise: { name: row.exercise, title: view.exercise.title ?? "", version: view.exercise.version }, everybody: row.cohort === null, exam: row.exam,
               counting: row.counting, summary: { students: students.length, graded: scores.length, ...figures } };
    }),
    students: students.map(({ id: own, login, display_name }, i) => ({ person: { id: own, login, display_name }, grades: grades[i] })),
  });
}

function moveAssignment({ world, person, request, id, body, query }) {
  const row = byId(world.assignments, id);
  const to = byId(world.exercises, body.exercise_id);
  const kept = world.attempts.filter((attempt) => attempt.assignment_id === id && attempt.exercise.id !== to.id);
  const answer = (moved, from) => ({ moved, from_version: from, to_version: to.version, attempts: kept.length, tickets: kept.filter((attempt) => attempt.state === "ticketed").length,
                                     assignment: assignmentView(world, row, person) });
  const from = assignmentView(world, row, person).exercise.version;
  if (query.get("dry_run") === "true") return json(answer(false, from));
  const refused = unseen(request, row, (now) => assignmentView(world, now, person));
  if (refused !== undefined) return refused;
  Object.assign(row, { version_id: to.id, revision: row.revision + 1 });
  return json(answer(true, from), 200, { ETag: `"${row.revision}"` });
}

function assignmentView(world, row, person) {
  const [newest] = publishedOf(world, row.exercise);
  const exercise = byId(world.exercises, row.version_id) ?? newest;
  const name = (rows, id) => ({ id, name: byId(rows, id)?.name ?? "" });
  const used = world.attempts.filter((attempt) => attempt.assignment_id === row.id && attempt.person.id === person.id && !attempt.flags.includes("excused")).length;
  const { version_id: _version, ...terms } = row;
  return {
    ...terms, exercise: { name: row.exercise, id: exercise?.id ?? null, title: exercise?.title ?? null, version: exercise?.version ?? 0,
                          newest_id: newest?.id ?? null, newest_version: newest?.version ?? null }, cohort: row.cohort === null ? null : name(world.cohorts, row.cohort),
    stations: row.stations.map((id) => name(world.stations, id)),
    mine: teaches(person) ? null : {
      attempts_used: used, attempts_left: row.attempt_limit === 0 ? null : Math.max(0, row.attempt_limit - used),
      refusal: row.opens_ms > world.nowMs ? "This exam is not open yet." : "",
      grade: gradeOf(world, row, person.id, world.attempts.filter((attempt) => !isHidden(world, attempt))) },
  };
}

function listAssignments({ world, person, query }) {
  const cohorts = world.cohorts.filter((cohort) => person.role === "admin" || cohort.members.includes(person.id)).map((cohort) => cohort.id);
  const rows = world.assignments.filter((row) => (row.cohort === null || cohorts.includes(row.cohort)) && (query.get("cohort") === null || row.cohort === query.get("cohort")));
  return json({ assignments: rows.map((row) => assignmentView(world, row, person)) });
}

function termsOf(body) {
  if (body.due_ms > 0 && body.due_ms <= body.opens_ms) return invalid("due_ms", "expected due_ms after opens_ms, or 0 for never");
  const { exercise, cohort_id: cohort, station_ids: stations, opens_ms, due_ms, attempt_limit, exam, late_allowed, hands = "listed", counting = "best" } = body;
  return { exercise, cohort, stations, opens_ms, due_ms, attempt_limit, exam, late_allowed, hands, counting };
}

function assign({ world, person, body }) {
  const terms = termsOf(body);
  if (terms.status !== undefined) return terms;
  const row = { id: newId(world), ...terms, version_id: publishedOf(world, terms.exercise)[0].id, created_ms: world.nowMs, revision: 1 };
  world.assignments.push(row);
  return tagged(assignmentView(world, row, person), 201);
}

function changeAssignment({ world, person, request, id, body }) {
  const terms = termsOf(body);
  if (terms.status !== undefined) return terms;
  return edit(request, byId(world.assignments, id), (row) => assignmentView(world, row, person), (row) => void Object.assign(row, terms));
}

function deleteAssignment({ world, request, id }) {
  const reply = edit(request, byId(world.assignments, id), (row) => row, () => undefined);
  if (reply.status !== 200) return reply;
  world.assignments = world.assignments.filter((row) => row.id !== id);
  return empty();
}

function releaseAssignment({ world, id }) {
  const rows = world.attempts.filter((row) => row.assignment_id === id && row.state === "scored" && !row.released);
  for (const row of rows) row.released = true;
  return json({ released: rows.length });
}

// Attempts

const isHidden = (world, row) => !row.released && (row.exam || byId(world.exercises, row.exercise.id)?.graded === true);

function visible(world, person, { override: _override, appeal: _appeal, runs: _runs, stopped: _stopped, ...row }) {
  const told = person.role === "student" ? { ...row, flags: row.flags.filter((flag) => flag !== "near_another") } : row;
  return person.role === "student" && isHidden(world, row) ? { ...told, score: null, computed_score: null, critical_fail: null } : told;
}

function detail(world, person, row) {
  const hidden = person.role === "student" && isHidden(world, row);
  return {
    ...visible(world, person, row), duration_s: row.ticks / 1000, time_limit_s: 600, reference: row.state === "scored" && !hidden ? referenceDetail : null,
    override: hidden ? null : row.override, appeal: row.appeal, contradictions: [], nearness: nearness(world, person, row),
    may: actionsOf(person, row) };
}

// The motion flagged near_another lies near the first attempt's of the same exercise by somebody else.
function nearness(world, person, row) {
  if (person.role === "student" || !row.flags.includes("near_another")) return null;
  const other = world.attempts.find(({ id, exercise, person: whose }) => id !== row.id && exercise.id === row.exercise.id && whose.id !== row.person.id);
  return { attempt_id: other?.id ?? null, person: other?.person ?? null, others: 12, nearest_mm: 0.018, median_mm: 0.94, size_mm: 1.32, worth_a_look: true };
}

function actionsOf(person, row) {
  const scored = row.state === "scored";
  const may = teaches(person)
    ? { release: scored && !row.released, unrelease: row.released, override: row.score !== null, annotate: true, rescore: row.sealed_ms > 0 && row.state !== "scoring",
        excuse: row.assignment_id !== null && !row.flags.includes("excused"), unexcuse: row.flags.includes("excused"), mark_reference: scored, answer_appeal: row.appeal?.state === "open" }
    : { appeal: scored && row.released && row.appeal === null };
  return Object.keys(may).filter((action) => may[action]);
}

function listAttempts({ world, person, query }) {
  const members = query.get("cohort") === null ? undefined : byId(world.cohorts, query.get("cohort"))?.members ?? [];
  const asked = (name, value) => query.get(name) === null || query.get(name) === value;
  const rows = world.attempts.filter((row) => (teaches(person) || row.person.id === person.id) && (members === undefined || members.includes(row.person.id)) &&
    asked("exercise", row.exercise.id) && asked("person", row.person.id) && asked("state", row.state) && asked("assignment", row.assignment_id) &&
    (query.get("flag") === null || row.flags.includes(query.get("flag"))) && (query.get("appeal") === null || row.appeal?.state === "open"));
  return page("attempts", rows.map((row) => visible(world, person, row)), query);
}

// Each look at an attempt that is being scored finds it further on.
function advance(row) {
  if (row.state !== "scoring") return;
  row.progress = Math.min(1, row.progress + kScoringStep);
  if (row.progress === 1) Object.assign(row, { state: "scored", score: row.override?.score ?? 80, computed_score: 80, critical_fail: false });
}

// `answer` gets the attempt when the caller may see it.
const withAttempt = (answer, needsScore = false) => (call) => {
  const row = byId(call.world.attempts, call.id);
  if (row === undefined || (!teaches(call.person) && row.person.id !== call.person.id)) return notFound();
  if (needsScore && row.state !== "scored") return conflict("The attempt is not scored yet.");
  return answer(row, call);
};

// What is said about an attempt is said by who has seen it as it is now.
const judged = (answer) => (row, call) => {
  const refused = unseen(call.request, row, (now) => detail(call.world, call.person, now));
  if (refused !== undefined) return refused;
  row.revision += 1;
  return answer(row, call);
};

const withScore = (answer) => withAttempt((row, call) => call.person.role === "student" && isHidden(call.world, row)
  ? refusal(403, "forbidden", "The score is not released yet.") : answer(row, call), true);

function toothReply(world, name, options) {
  if (!world.surfaces.has(name)) world.surfaces.set(name, toothSurface(options));
  return { status: 200, body: world.surfaces.get(name), headers: { "Content-Type": "application/octet-stream", "Cache-Control": "no-store" } };
}

const playback = (pace = 1) => mockPlayback(seriesEndS(), pace);

function timeline(row, { request }) {
  const bytes = playback(paceOf(row.id)).timeline;
  const [, from, to] = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? "") ?? [];
  const headers = { "Content-Type": "application/octet-stream", "Cache-Control": "no-store", ETag: '"mock"' };
  return from === undefined ? { status: 200, body: bytes, headers } : { status: 206, body: bytes.subarray(Number(from), Number(to) + 1), headers };
}

const deviation = () => ({ status: 200, body: playback().deviation, headers: { "Content-Type": "application/octet-stream", "Cache-Control": "no-store" } });
const startTooth = () => ({ status: 200, body: playback().start, headers: { "Content-Type": "application/octet-stream", "Cache-Control": "private, max-age=31536000, immutable" } });

function override(row, { world, person, body }) {
  if (!(body.score >= 0 && body.score <= 100)) return invalid("score", "expected a number of 0 to 100");
  row.override = { score: body.score, reason: body.reason, by: person.display_name, at_ms: world.nowMs };
  row.score = body.score;
  return json(detail(world, person, row));
}

function dropOverride(row, { world, person }) {
  Object.assign(row, { override: null, score: row.computed_score });
  return json(detail(world, person, row));
}

function rescore(row, { world, person }) {
  Object.assign(row, { state: "scoring", progress: 0, runs: row.runs + 1 });
  return json(detail(world, person, row), 202);
}

function makeReference(row, { world, body }) {
  if (row.gap_ticks > 0 && body.anyway === undefined) {
    return refusal(409, "conflict", "this attempt cannot be what others are compared with: 4.1 % of its time is missing; take another attempt, or say why this one is right all the same", "anyway");
  }
  for (const other of world.attempts) other.is_reference = other === row;
  const reference = { id: newId(world), exercise_id: row.exercise.id, attempt_id: row.id, dentist: body.dentist, consent: body.consent, version: world.references.length + 1,
                      created_ms: world.nowMs, withdrawn_ms: 0 };
  world.references.unshift(reference);
  return json(reference, 201);
}

function runs(row) {
  return json({ results: Array.from({ length: row.runs }, (_, i) => ({
    run: row.runs - i, scored_ms: row.sealed_ms + (row.runs - i) * 60_000, cause: i === row.runs - 1 ? "seal" : "appeal", restorable: i === 1, reference_attempt: null, replay_realtime_factor: 31.4,
    score: scoreOf(row) })) });
}

const remarkView = (person) => (row) => ({ ...row, mine: row.author.id === person.id });

function annotate(row, { world, person, body }) {
  const remark = { id: newId(world), attempt_id: row.id, author: { id: person.id, display_name: person.display_name }, tick: body.tick, point_um: body.point_um ?? null,
                   text: body.text, to_chair: false, created_ms: world.nowMs, edited_ms: 0, revision: 1 };
  world.annotations.push(remark);
  return tagged(remarkView(person)(remark), 201);
}

function editRemark({ world, person, request, id, body }) {
  return edit(request, byId(world.annotations, id), remarkView(person), (row) => void Object.assign(row, { ...body, edited_ms: world.nowMs }));
}

function deleteRemark({ world, request, id }) {
  const reply = edit(request, byId(world.annotations, id), (row) => row, () => undefined);
  if (reply.status !== 200) return reply;
  world.annotations = world.annotations.filter((row) => row.id !== id);
  return empty();
}

function fileAppeal(row, { world, person, body }) {
  if (!row.released || row.appeal !== null) return conflict("There is nothing to appeal against.");
  row.appeal = { filed_ms: world.nowMs, text: body.text, state: "open", answer: "", answered_ms: 0 };
  return json(detail(world, person, row), 201);
}

function answerAppeal(row, { world, person, body }) {
  Object.assign(row.appeal, { state: body.outcome === "regrade" ? "regraded" : "rejected", answer: body.answer, answered_ms: world.nowMs });
  if (body.outcome === "regrade") rescore(row, { world, person });
  return json(detail(world, person, row));
}

// Server-sent events of a hand that circles in the tooth.
function live(row, { world }) {
  if (row.state !== "recording") return conflict("The attempt is not being made.");
  let tick = Math.round(row.ticks) + (world.nowMs % 1000);
  const rowAt = (at) => {
    const phase = at / 900;
    return [at, Math.round(1800 * Math.cos(phase)), Math.round(1100 * Math.sin(phase)), Math.round(-400 - 250 * Math.sin(phase / 3)),
            Math.round(-300 * Math.cos(phase)), Math.round(-200 * Math.sin(phase)), Math.round(900 + 500 * Math.sin(phase * 1.7)), 16];
  };
  const event = () => {
    const rows = Array.from({ length: kRowsPerEvent }, () => rowAt((tick += 15)));
    return `event: ticks\ndata: ${JSON.stringify({ tick, rows })}\n\n`;
  };
  return { status: 200, headers: { "Content-Type": "text/event-stream", "Cache-Control": "no-store" }, stream: (response) => {
    const timer = setInterval(() => {
      if (row.state === "recording") return void response.write(event());
      clearInterval(timer);
      response.end("event: end\ndata: {}\n\n");
    }, kLiveEventMs);
    response.on("close", () => clearInterval(timer));
  } };
}

// A chair that shows what it is sent when it is asked for the second time; `row.chair` is what its station is.
function liveRemarks(row) {
  const remarks = row.said ?? [];
  for (const remark of remarks) {
    if (remark.state === "sent") Object.assign(remark, { state: "shown", shown_ms: remark.sent_ms + 900 });
    else if (remark.state === "waiting") remark.state = "sent";
  }
  return json({ remarks, station: row.chair ?? { connected: true, shows_remarks: true }, allowed: true, max_characters: 500 });
}

function sendLiveRemark(row, { world, person, body }) {
  const id = world.nowMs + (row.said?.length ?? 0);
  const remark = { id, text: body.text, from: person.display_name, sent_ms: world.nowMs, tick: 72_000, state: "waiting", shown_ms: null };
  (row.said ??= []).push(remark);
  return json(remark, 201);
}

const exercise = (answer) => (call) => {
  const row = byId(call.world.exercises, call.id);
  return row === undefined || (row.state === "draft" && !teaches(call.person)) ? notFound() : answer(row, call);
};
const changed = (change) => (row, call) => change(row, call) ?? empty();

// "METHOD /path with {id}": [who may, answer].
export const teachingRoutes = {
  "GET /exercises": ["person", listExercises],
  "POST /exercises": ["instructor", putDraft],
  "GET /exercises/{id}": ["person", exercise((row, { world, person }) => tagged(wholeFor(world, person, row)))],
  "PUT /exercises/{id}": ["instructor", replaceDraft],
  "DELETE /exercises/{id}": ["instructor", deleteDraft],
  "GET /exercises/{id}/initial-surface": ["person", exercise((_row, { world }) => toothReply(world, "whole", { withDeviation: false, whole: true }))],
  "GET /exercises/{id}/versions": ["person", versionsOf],
  "GET /exercises/{id}/references": ["person", ({ world, id }) => json({ references: world.references.filter((row) => row.exercise_id === id) })],
  "POST /exercises/{id}/publish": ["instructor", (call) => changeDraft(call, (row) => void Object.assign(row, { state: "published", version: 1, published_ms: call.world.nowMs }))],
  "POST /exercises/{id}/retire": ["instructor", exercise(changed((row) => void Object.assign(row, { state: "retired", revision: row.revision + 1 })))],
  "PUT /exercises/{id}/sharing": ["instructor", share],
  "POST /references/{id}/withdraw": ["instructor", ({ world, id }) => {
    byId(world.references, id).withdrawn_ms = world.nowMs;
    return empty();
  }],
  "GET /assignments": ["person", listAssignments],
  "POST /assignments": ["instructor", assign],
  "GET /assignments/{id}": ["person", ({ world, person, id }) => {
    const row = byId(world.assignments, id);
    return row === undefined ? notFound() : tagged(assignmentView(world, row, person));
  }],
  "PUT /assignments/{id}": ["instructor", changeAssignment],
  "DELETE /assignments/{id}": ["instructor", deleteAssignment],
  "POST /assignments/{id}/move": ["instructor", moveAssignment],
  "GET /cohorts/{id}/grades": ["instructor", cohortGrades],
  "GET /assignments/{id}/insight": ["instructor", assignmentInsight],
  "POST /assignments/{id}/release": ["instructor", releaseAssignment],
  "GET /attempts": ["person", listAttempts],
  "GET /attempts/{id}": ["person", withAttempt((row, { world, person }) => {
    advance(row);
    return json(detail(world, person, row));
  })],
  "GET /attempts/{id}/score": ["person", withScore((row) => json(scoreOf(row)))],
  "GET /attempts/{id}/ticks": ["person", withScore((row, { query }) => json(ticksOf(Number(query.get("from") ?? 0), Number(query.get("to")))))],
  "GET /attempts/{id}/series": ["person", withScore((row) => json(seriesOf(paceOf(row.id))))],
  "GET /attempts/{id}/surface": ["person", withScore((_row, { world }) => toothReply(world, "compared", { withDeviation: true }))],
  "GET /attempts/{id}/timeline": ["person", withScore(timeline)],
  "GET /attempts/{id}/deviation": ["person", withScore(deviation)],
  "GET /start-teeth/{name}": ["person", startTooth],
  "GET /attempts/{id}/live": ["instructor", withAttempt(live)],
  "GET /live/{id}/remarks": ["instructor", withAttempt(liveRemarks)],
  "POST /live/{id}/remarks": ["instructor", withAttempt(sendLiveRemark)],
  "GET /attempts/{id}/results": ["person", withScore(runs)],
  "GET /attempts/{id}/annotations": ["person", withScore((row, { world, person }) =>
    json({ annotations: world.annotations.filter((remark) => remark.attempt_id === row.id).map(remarkView(person)) }))],
  "POST /attempts/{id}/annotations": ["instructor", withAttempt(annotate)],
  "PUT /annotations/{id}": ["instructor", editRemark],
  "DELETE /annotations/{id}": ["instructor", deleteRemark],
  "POST /attempts/{id}/release": ["instructor", withAttempt(judged(changed((row) => { row.released = true; })))],
  "DELETE /attempts/{id}/release": ["instructor", withAttempt(judged(changed((row) => { row.released = false; })))],
  "POST /attempts/{id}/reference": ["instructor", withAttempt(makeReference)],
  "PUT /attempts/{id}/override": ["instructor", withAttempt(judged(override))],
  "DELETE /attempts/{id}/override": ["instructor", withAttempt(judged(dropOverride))],
  "POST /attempts/{id}/rescore": ["instructor", withAttempt(rescore)],
  "POST /attempts/{id}/excuse": ["instructor", withAttempt(judged((row, { world, person }) => {
    row.flags.push("excused");
    return json(detail(world, person, row));
  }))],
  "DELETE /attempts/{id}/excuse": ["instructor", withAttempt(judged((row, { world, person }) => {
    row.flags = row.flags.filter((flag) => flag !== "excused");
    return json(detail(world, person, row));
  }))],
  "POST /attempts/{id}/restore-result": ["instructor", withAttempt(judged((row, { world, person, body }) => {
    if (body.run > row.runs) return refusal(404, "not_found", `There is no scoring run ${body.run}.`);
    Object.assign(row, { state: "scored", progress: 1, runs: body.run === row.runs ? row.runs : row.runs + 1 });
    return json(detail(world, person, row));
  }))],
  "POST /attempts/{id}/appeal": ["person", withAttempt(fileAppeal)],
  "POST /attempts/{id}/appeal/answer": ["instructor", withAttempt(answerAppeal)],
};
