// Documents of exercises and rubrics as the forms edit them, in the shapes of schemas/exercise.schema.json and rubric.schema.json.
import { readFileSync } from "node:fs";
import { conflict, invalid, json, notFound, unseen } from "./mock_reply.mjs";

const golden = JSON.parse(readFileSync(new URL("../../schemas/golden/scene_exercise_gates.json", import.meta.url)));
const byId = (rows, id) => rows.find((row) => row.id === id);
const kMetrics = [["wall_mesial_mm", "mm"], ["deviation_rms_mm", "mm"], ["floor_mm", "mm"], ["force_sent_p95_n", "N"], ["time_s", "s"], ["task_done_percent", "%"], ["pulp_exposed_mm2", "mm2"],
                  ["reduction_mesial_mm", "mm"], ["reduction_distal_mm", "mm"], ["reduction_buccal_mm", "mm"], ["reduction_lingual_mm", "mm"], ["reduction_top_mm", "mm"], ["finish_width_mm", "mm"], ["damage_percent", "%"]];

// Kept once it was asked for, so that a draft that was saved reads as it was saved.
export function documentOf(world, row) {
  world.documents ??= new Map();
  const version = row.version === 0 ? row.revision : row.version;
  if (!world.documents.has(row.id)) world.documents.set(row.id, { ...golden, name: row.name, title: row.title, instructions: row.instructions, graded: row.graded, time_limit_s: row.time_limit_s + 60 * (version - 1) });
  return world.documents.get(row.id);
}

// What is wrong with a rubric, as the server names the place.
function wrongRubric({ criteria = [], gates = [] }, prefix) {
  for (const [name, list] of [["criteria", criteria], ["gates", gates]]) {
    for (const [i, item] of list.entries()) {
      const place = `${prefix}${name}[${i}]`;
      const points = prefix === "" ? `/${name}/${i}/points` : `${place}.points`;  // by the schema, or by its rules
      if (name === "criteria" && !(item.points >= 0 && item.points <= 1000)) return invalid(points, `${points}: expected a number from 0E0 to 1E3, found ${JSON.stringify(item.points)}`);
      if (item.title === "") return invalid(`${place}.title`, "expected 1 to 200 bytes, found none");
      if (item.map.some(([, share]) => share < 0 || share > 1)) return invalid(`${place}.map`, "expected shares of 0 to 1");
      if (item.map.some(([value], row) => row > 0 && value <= item.map[row - 1][0])) return invalid(`${place}.map`, "expected rising values");
    }
  }
  return criteria.some((item) => item.points > 0) ? undefined : invalid(`${prefix}criteria`, "rubric: no criterion gives points, so there is no score");
}

export function lookAtExercise(body) {
  if (body.title === "") return invalid("title", "expected 1 to 200 bytes, found none");
  return wrongRubric(body.rubric ?? {}, "rubric.") ?? json({ warnings: [] });
}

function rubricsOf(world, row) {
  world.rubrics ??= new Map();
  if (!world.rubrics.has(row.id)) world.rubrics.set(row.id, [{ version: 1, reason: "", published_ms: row.published_ms, document: { format: 1, ...documentOf(world, row).rubric } }]);
  return world.rubrics.get(row.id);
}

const tenths = (scores) => scores.reduce((out, score) => { ++out[Math.min(9, Math.floor(score / 10))]; return out; }, Array(10).fill(0));

function preview({ world, id, body, query }) {
  const wrong = wrongRubric(body, "");
  if (wrong !== undefined) return wrong;
  const scored = query.get("attempts") === "false" ? [] : world.attempts.filter((row) => row.exercise.id === id && row.state === "scored");
  const total = body.criteria.reduce((sum, item) => sum + item.points, 0);
  const attempts = scored.map((row) => ({ attempt_id: row.id, person: row.person, before: row.computed_score, after: Math.min(100, row.computed_score * (total / 100)), failed_before: false, failed_after: false,
                                         overridden: false, released: row.released, earlier_reference: false, problem: "" }));
  const mean = (values) => values.length === 0 ? 0 : values.reduce((sum, value) => sum + value, 0) / values.length;
  return json({ warnings: [], attempts, raised: attempts.filter((row) => row.after > row.before).length, lowered: attempts.filter((row) => row.after < row.before).length, problems: 0, earlier_references: 0, withdrawn: 0,
                mean_before: mean(attempts.map((row) => row.before)), mean_after: mean(attempts.map((row) => row.after)),
                histogram_before: tenths(attempts.map((row) => row.before)), histogram_after: tenths(attempts.map((row) => row.after)) });
}

function publish({ world, id, body, request }) {
  const rubrics = rubricsOf(world, byId(world.exercises, id));
  const refused = unseen(request, { revision: rubrics[0].version }, () => rubrics[0]);
  if (refused !== undefined) return refused;
  if (JSON.stringify(body.rubric) === JSON.stringify(rubrics[0].document)) return conflict("the rubric that counts says the same already");
  rubrics.unshift({ version: rubrics[0].version + 1, reason: body.reason, published_ms: world.nowMs, document: body.rubric });
  return json(rubrics[0], 201, { ETag: `"${rubrics[0].version}"` });
}

export const editingRoutes = {
  "GET /scoring-metrics": ["instructor", () => json({ metrics: kMetrics.map(([name, unit]) => ({ name, unit, title: name, formula: "" })) })],
  "GET /exercises/{id}/document": ["person", ({ world, id }) => {
    const row = byId(world.exercises, id);
    return row === undefined ? notFound() : json(documentOf(world, row));
  }],
  "GET /exercises/{id}/rubrics": ["instructor", ({ world, id }) => {
    const rubrics = rubricsOf(world, byId(world.exercises, id));
    return json({ rubrics }, 200, { ETag: `"${rubrics[0].version}"` });
  }],
  "POST /exercises/{id}/rubrics": ["instructor", publish],
  "POST /exercises/{id}/rubrics/preview": ["instructor", preview],
};
