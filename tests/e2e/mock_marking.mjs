// Blind marking of the mock server: who marks what, and, once all are done, figures from a sample.
import { conflict, invalid, refused, Reply } from "./contract.mjs";
import { scoreOf } from "./mock_exercises.mjs";
import { playbackOf } from "./mock_tooth.mjs";
import { added, newId } from "./mock_world.mjs";

const kMostWorks = 9;

const noWork = () => refused(404, "not_found", "There is no such work that you mark.");
const criteriaOf = ({ works }) => scoreOf(works[0].attempt).criteria.filter(({ max_points: most }) => most > 0);
const doneBy = ({ works }, person) => works.every(({ marks }) => marks.some(({ marker }) => marker === person));
const isDone = (row) => row.markers.every((person) => doneBy(row, person));

const summaryOf = (row) => ({
  ...row,
  works: row.works.length,
  done: isDone(row),
  markers: row.markers.map((person) => ({
    ...person,
    marked: row.works.filter(({ marks }) => marks.some(({ marker }) => marker === person)).length,
  })),
});

function begin(call) {
  const { world, row, body } = call;
  const markers = body.marker_ids.map((id) => world.people.find((person) => person.id === id));
  if (markers.some((person) => person === undefined || person.role === "student"))
    return invalid("marker_ids", "expected instructors or admins who may sign in");
  if (world.markings.some((each) => each.assignment_id === row.id && each.ended_ms === 0 && !isDone(each)))
    return conflict("a marking of this assignment is under way");
  const attempts = world.attempts.filter((each) => each.assignment_id === row.id && each.state === "scored");
  return summaryOf(
    added(world, world.markings, {
      assignment_id: row.id,
      ended_ms: 0,
      markers,
      works: attempts.slice(0, kMostWorks).map((attempt) => ({ id: newId(world), attempt, marks: [] })),
    }),
  );
}

const figure = (value) => ({ value, low: value - 0.2, high: Math.min(1, value + 0.1) });

function resultsOf(row) {
  const titles = criteriaOf(row).map(({ title }) => title);
  return {
    works: row.works.map(({ id, attempt, marks }) => ({
      id,
      attempt_id: attempt.id,
      person: attempt.person,
      computed_score: attempt.score,
      marks: marks.map((mark) => ({ ...mark, marker_id: mark.marker.id })),
    })),
    agreement: [...titles, "rating", "total"].map((criterion) => ({
      criterion,
      works: row.works.length,
      left_out: 0,
      icc_2_1: criterion === titles[0] ? { value: null, why: "all marks are the same" } : figure(0.82),
      phi: figure(0.88),
      weighted_kappa: figure(0.7),
      ...(criterion === "rating" ? {} : { computed: { works: row.works.length, icc_2_1_with_mean: figure(0.74) } }),
    })),
    standard: {
      borderline: {
        needs: { works: 8, ratings: 3, enough: 30 },
        value: 58.4,
        low: 51.2,
        high: 64.9,
        points_per_rating: 9.5,
        explained: 0.71,
        works: row.works.length,
        ratings: 2 * row.works.length,
        few: true,
      },
      angoff: { value: null, why: "expected two examiners at least", examiners: 0, criteria: [] },
      cut: 58.4,
      phi: figure(0.88),
      phi_at_cut: figure(0.91),
      icc_2_1: figure(0.82),
      warnings: [],
    },
  };
}

function markingOf({ world, row, person }) {
  const exercise = row.works[0].attempt.exercise;
  const mine = row.markers.includes(person)
    ? row.works.map(({ id, marks }) => ({ id, marked: marks.some(({ marker }) => marker === person) }))
    : [];
  const said = world.markings
    .flatMap(({ works }) => works.flatMap(({ marks }) => marks))
    .filter(({ marker }) => marker === person)
    .flatMap(({ criteria }) => criteria)
    .filter(({ comment }) => comment !== "");
  return {
    ...summaryOf(row),
    exercise,
    criteria: criteriaOf(row),
    mine,
    comments: said,
    results: isDone(row) ? resultsOf(row) : null,
  };
}

function mark({ world, id, person, body }) {
  const row = world.markings.find(({ works }) => works.some((work) => work.id === id));
  if (row === undefined || !row.markers.includes(person)) return noWork();
  const work = row.works.find((each) => each.id === id);
  if (row.ended_ms > 0) return conflict("this marking was given up");
  if (work.marks.some(({ marker }) => marker === person)) return conflict("you have marked this work already");
  const criteria = criteriaOf(row);
  const wrong = criteria.find(({ name, max_points: most }) => !(body.criteria[name]?.points <= most));
  if (wrong !== undefined) return invalid("criteria", `expected points from 0 to ${wrong.max_points}`);
  const given = criteria.map((each) => ({ ...each, comment: "", ...body.criteria[each.name] }));
  const sum = (of) => given.reduce((total, each) => total + each[of], 0);
  work.marks.push({
    marker: person,
    rating: body.rating,
    criteria: given,
    total: (100 * sum("points")) / sum("max_points"),
    made_ms: world.nowMs,
  });
  return undefined;
}

export const markingRules = {
  "GET /assignments/{id}/markings": ({ world, row }) => ({
    markings: world.markings.filter((each) => each.assignment_id === row.id).map(summaryOf),
  }),
  "POST /assignments/{id}/markings": begin,
  "GET /markings/{id}": markingOf,
  "DELETE /markings/{id}": ({ world, row }) => {
    row.ended_ms = world.nowMs;
  },
  "POST /marking-works/{id}/marks": mark,
  "GET /marking-works/{id}/timeline": () => new Reply(playbackOf().timeline),
};
