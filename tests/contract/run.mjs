// Asks a running server every operation of schemas/api/openapi.yaml as every role, with right and wrong bodies, and holds
// status, headers and body of each answer against it: run.mjs [OPENAPI.yaml].
import { readFileSync } from "node:fs";
import { Contract } from "./contract.mjs";
import { Asking } from "./asking.mjs";
import { startSchool } from "./school.mjs";
import * as of_people from "./people_steps.mjs";
import * as of_teaching from "./teaching_steps.mjs";

const contract = new Contract(process.argv[2] && readFileSync(process.argv[2], "utf8"));
const began = performance.now();
const { w, close } = await startSchool();
w.metrics = contract.document.components.schemas.MetricName.enum;
const asking = new Asking(contract, w);
// However slow the machine was until here: what is sensitive asks for the password again after some minutes.
const confirmed = () => w.admin.need("POST", "/api/v1/session/confirm", { body: { password: w.admin.password } });
const made_s = (performance.now() - began) / 1000;
try {
  await asking.steps(of_people.people);
  await asking.steps(of_teaching.exercises);
  await asking.steps(of_teaching.assignments);
  const leave = await w.work();
  await asking.steps(of_teaching.live);
  await leave();
  await asking.steps(of_teaching.marking);
  await asking.steps(of_teaching.attempts);
  await confirmed();
  await asking.steps(of_people.devices);
  await asking.steps(of_people.server);
  await confirmed();
  await asking.steps(of_people.last);
  await asking.methods();
} finally {
  await close();
}
const problems = asking.problems();
for (const problem of problems) console.error(problem);
const took_s = (performance.now() - began) / 1000;
console.log(
  `${asking.answers} answers of ${contract.operations.length} operations, ${problems.length} kinds of difference; ` +
    `${took_s.toFixed(1)} s, ${made_s.toFixed(1)} s of them for the school`,
);
process.exit(problems.length > 0 ? 1 : 0);
