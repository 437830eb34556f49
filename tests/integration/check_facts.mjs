// Checks the facts ./run --json wrote: node check_facts.mjs FILE
import { readFileSync } from "node:fs";

const facts = JSON.parse(readFileSync(process.argv[2], "utf8"));
const problems = [];
const expect = (what, ok, found) => { if (!ok) problems.push(`${what}; found ${JSON.stringify(found)}`); };

for (const key of ["attempt_id", "reference_id", "score", "criteria", "mistakes", "deviation_rms_mm", "ticks", "chunks",
  "gaps", "witness_ok", "trace_bytes", "realtime_factor", "page_url"]) {
  expect(`has ${key}`, key in facts, Object.keys(facts));
}
expect("at least 30 000 ticks", facts.ticks >= 30000, facts.ticks);
expect("no gaps", facts.gaps === 0, facts.gaps);
expect("the replay agrees", facts.witness_ok === true, facts.witness_ok);
expect("at most 12 bytes a tick", facts.trace_bytes / facts.ticks <= 12, facts.trace_bytes / facts.ticks);
// Empty: the exercise's own target was the kindest.
expect("not compared with itself", facts.reference_id !== facts.attempt_id, facts.reference_id);
expect("page address", /^http:\/\/127\.0\.0\.1:\d+\/attempts\//.test(facts.page_url), facts.page_url);
// The simulated student's one deliberate error.
const [mistake] = facts.mistakes;
expect("the mesial wall over-extended", mistake?.kind === "over_extended" && mistake.place === "wall_mesial", mistake);
expect("by 0.3 mm", Math.abs(mistake?.size - 0.3) <= 0.06, mistake);
for (const { place, points } of facts.mistakes.slice(1)) {
  expect("nothing else that costs as much", points < mistake.points / 4, { place, points });
}
expect("the lost wall costs points", facts.score > 50 && facts.score < 97, facts.score);
for (const c of facts.criteria) {
  expect("criterion complete", typeof c.name === "string" && typeof c.value === "number" && typeof c.unit === "string" &&
    typeof c.lost === "number" && (c.group !== "hand" || c.reason.length > 10), c);
}
const sum = (list, of) => list.reduce((all, each) => all + of(each), 0);
const [lost, explained] = [sum(facts.criteria.filter((c) => c.group !== "hand"), (c) => c.lost), sum(facts.mistakes, (m) => m.points)];
expect("mistakes explain what the groups lost", Math.abs(lost - explained) < 1e-6, { lost, explained });
if (problems.length > 0) {
  console.error(problems.map((p) => `FAILED: expected ${p}`).join("\n"));
  process.exit(1);
}
console.log(`score ${facts.score.toFixed(1)}, mesial wall ${mistake.size.toFixed(2)} mm too far, ${facts.ticks} ticks`);
