// Checks the facts ./run --json wrote: node check_facts.mjs FILE
import { readFileSync } from "node:fs";

const facts = JSON.parse(readFileSync(process.argv[2], "utf8"));
const problems = [];
const expect = (what, ok, found) => { if (!ok) problems.push(`${what}; found ${JSON.stringify(found)}`); };

for (const key of ["attempt_id", "reference_id", "score", "criteria", "deviation_rms_mm", "ticks", "chunks",
  "gaps", "witness_ok", "trace_bytes", "realtime_factor", "page_url"]) {
  expect(`has ${key}`, key in facts, Object.keys(facts));
}
expect("at least 30 000 ticks", facts.ticks >= 30000, facts.ticks);
expect("no gaps", facts.gaps === 0, facts.gaps);
expect("the replay agrees", facts.witness_ok === true, facts.witness_ok);
expect("at most 12 bytes a tick", facts.trace_bytes / facts.ticks <= 12, facts.trace_bytes / facts.ticks);
expect("compared with another attempt", facts.reference_id && facts.reference_id !== facts.attempt_id, facts.reference_id);
expect("page address", /^http:\/\/127\.0\.0\.1:\d+\/attempts\//.test(facts.page_url), facts.page_url);
const value = (name) => facts.criteria.find((c) => c.name === name)?.value;
// The simulated student's one deliberate error, to a quarter of the 0.05 mm voxel.
expect("mesial wall 0.3 mm too deep", Math.abs(value("wall_mesial_mm") - 0.3) <= 0.0125, value("wall_mesial_mm"));
for (const wall of ["wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm", "floor_mm"]) {
  expect(`${wall} where it should be`, Math.abs(value(wall)) <= 0.025, value(wall));
}
expect("the lost wall costs points", facts.score > 50 && facts.score < 97, facts.score);
for (const c of facts.criteria) {
  expect("criterion complete", typeof c.name === "string" && typeof c.value === "number" && typeof c.unit === "string" &&
    typeof c.points === "number" && c.reason.length > 10, c);
}
if (problems.length > 0) {
  console.error(problems.map((p) => `FAILED: expected ${p}`).join("\n"));
  process.exit(1);
}
console.log(`score ${facts.score.toFixed(1)}, mesial wall ${value("wall_mesial_mm").toFixed(4)} mm, ${facts.ticks} ticks`);
