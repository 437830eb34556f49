// How a class did, invented: schema AssignmentInsight.
import { scoreOf } from "./mock_data.mjs";
import { json, notFound } from "./mock_reply.mjs";

const byId = (rows, id) => rows.find((row) => row.id === id);

function spread(values) {
  const all = values.filter(Number.isFinite).sort((a, b) => a - b);
  const at = (share) => all[Math.round(share * (all.length - 1))];
  return all.length === 0 ? null : { count: all.length, least: all[0], lower: at(0.25), median: at(0.5), upper: at(0.75), most: all.at(-1) };
}

function tenths(percents) {
  const out = Array(10).fill(0);
  for (const percent of percents) ++out[Math.min(9, Math.max(0, Math.floor(percent / 10)))];
  return out;
}

const viewOf = ({ id, login, display_name }) => ({ id, login, display_name });

// No two students' points are the same, although the mock has one score document for all.
const pointsOf = ({ points, max_points: most }, i, column) => Math.max(0, Math.min(most, points * (0.4 + (((i + 3) * (column + 5) * 7) % 13) / 10)));

export function assignmentInsight({ world, id }) {
  const row = byId(world.assignments, id);
  if (row === undefined) return notFound();
  const members = row.cohort === null ? world.people.map((person) => person.id) : byId(world.cohorts, row.cohort).members;
  const people = world.people.filter((person) => members.includes(person.id));
  const under = (person) => world.attempts.filter((attempt) => attempt.assignment_id === id && attempt.person.id === person.id && !attempt.flags.includes("excused"));
  const criteria = scoreOf({ computed_score: 80, ticks: 0, gap_ticks: 0 }).criteria;
  const students = people.filter((person) => person.role === "student").map((person, i) => {
    const made = under(person);
    const scored = made.filter((attempt) => attempt.score !== null).sort((a, b) => b.score - a.score);
    return {
      person: viewOf(person), state: made.length === 0 ? "not_started" : scored.length === 0 ? "waiting" : "scored", attempts: made.length, score: scored[0]?.score ?? null,
      released: scored[0]?.released ?? false, time_s: made.reduce((sum, attempt) => sum + attempt.ticks / 1000, 0) * (i === 7 ? 14 : 1 + (i % 5) / 6), failed: scored[0]?.critical_fail ?? false,
      attempt_id: scored[0]?.id ?? null, points: scored.length === 0 ? [] : criteria.map((criterion, column) => pointsOf(criterion, i, column)),
    };
  });
  const scored = students.filter((student) => student.state === "scored");
  const begun = students.filter((student) => student.state !== "not_started");
  const told = scored.length === 0 ? [] : criteria.map(({ name, title, unit, value, max_points: most }, column) => {
    const points = scored.map((student) => student.points[column]);
    return { name, title, unit, max_points: most, judged: scored.length, half_lost: points.filter((each) => each <= most / 2).length,
             mean_points: points.reduce((sum, each) => sum + each, 0) / points.length, earned_tenths: tenths(points.map((each) => (100 * each) / most)),
             values: spread(points.map((each, i) => value * (0.6 + (i % 7) / 8))) };
  });
  const commonest = [...told].sort((a, b) => b.half_lost - a.half_lost)[0];
  const late = scored.find((student) => student.time_s > 300);
  return json({
    assignment_id: id, counting: row.counting, criteria: told, commonest: commonest?.half_lost > 0 ? commonest.name : null,
    summary: { students: students.length, not_started: students.length - begun.length, waiting: begun.length - scored.length, scored: scored.length, failed: scored.filter((student) => student.failed).length,
               scores: spread(scored.map((student) => student.score)), times_s: spread(begun.map((student) => student.time_s)), score_tenths: tenths(scored.map((student) => student.score)) },
    gates: scored.length === 0 ? [] : [{ name: "task_done_percent", title: "Task done", taken: 1 }],
    outliers: late === undefined ? [] : [{ person_id: late.person.id, what: "time_all_attempts_s", value: late.time_s, median: spread(begun.map((student) => student.time_s)).median, z: 9.1 }],
    students: students.map((student) => ({ ...student, points: student.points.length === 0 ? told.map(() => null) : student.points })),
    staff: world.attempts.filter((attempt) => people.some((person) => person.role !== "student" && person.id === attempt.person.id) && attempt.exercise.id === world.exercises.find((item) => item.name === row.exercise)?.id).map((attempt) => ({
      person: viewOf(byId(world.people, attempt.person.id)), attempt_id: attempt.id, score: attempt.score, time_s: attempt.ticks / 1000, ticketed_ms: attempt.ticketed_ms, as_reference: attempt.as_reference })),
    left_out: 0, unread: 0,
  });
}
