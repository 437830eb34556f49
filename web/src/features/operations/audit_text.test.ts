import assert from "node:assert/strict";
import { test } from "node:test";
import { detailsOf, peopleIn, shortId, thingOf, whereText } from "./audit_text";

const id = (number: number) => `00000000-0000-7000-8000-${String(number).padStart(12, "0")}`;
const entry = (action: string, object: string, before = "", after = "") => ({
  at_ms: 1,
  actor: `${id(3)} (page)`,
  action,
  object,
  before,
  after,
});

test("empty details are left out, and so is what stayed as it was", () => {
  assert.deepEqual(detailsOf({ before: "{}", after: "{}" }), []);
  assert.deepEqual(detailsOf({ before: "", after: "" }), []);
  assert.deepEqual(
    detailsOf({
      before: '{"role":"student","name":"A"}',
      after: '{"role":"instructor","name":"A","stations":[],"note":null}',
    }),
    [{ name: "Role", before: "student", after: "instructor" }],
  );
});

test("values are shown as people read them: times as dates, people by name, yes and no", () => {
  const details = detailsOf(
    { before: "{}", after: `{"due_ms":${Date.UTC(2026, 2, 9)},"opens_ms":0,"exam":true,"person":"${id(7)}"}` },
    (person) => (person === id(7) ? "Student Seven" : person),
  );
  assert.deepEqual(
    details.map(({ name }) => name),
    ["Due", "Exam", "Person"],
  );
  assert.match(details[0]?.after ?? "", /2026/);
  assert.equal(details[1]?.after, "yes");
  assert.equal(details[2]?.after, "Student Seven");
});

test("why an attempt has no score is told in words where the server names the reason", () => {
  const after = (field: string) => JSON.stringify({ problem: "chunk 7 is missing: …", problem_field: field });
  assert.match(
    detailsOf({ before: "", after: after("unreadable") })[0]?.after ?? "",
    /^The server cannot read this recording/,
  );
  assert.deepEqual(
    detailsOf({ before: "", after: after("") }).map(({ after: text }) => text),
    ["chunk 7 is missing: …"],
  );
});

test("a refused request names who asked once, and the reason in words", () => {
  assert.equal(thingOf(entry("request.refused", id(3))), undefined);
  assert.deepEqual(
    detailsOf({ before: "{}", after: '{"count":"10","reason":"one-time","request":"GET /api/v1/people"}' }),
    [
      { name: "Times", before: "", after: "10" },
      { name: "Reason", before: "", after: "one-time password" },
      { name: "Request", before: "", after: "GET /api/v1/people" },
    ],
  );
});

test("where somebody was is told in words, and not where it was the page", () => {
  assert.equal(whereText(`${id(3)} (page)`, id(3)), "");
  assert.equal(whereText(`${id(3)} (station Chair 1)`, id(3)), " (station Chair 1)");
  assert.equal(whereText(`${id(3)} (elsewhere)`, id(3)), " (elsewhere)");
});

test("text that is no JSON object is shown unchanged", () => {
  assert.deepEqual(detailsOf({ before: "", after: "not json" }), [{ name: "Value", before: "", after: "not json" }]);
});

test("what something was done to is named by its kind, ids are shortened", () => {
  assert.deepEqual(thingOf(entry("annotation.add", id(105))), {
    kind: "attempt",
    id: id(105),
    text: "attempt …000105",
  });
  assert.equal(thingOf(entry("person.edit", id(7)))?.kind, "person");
  assert.equal(thingOf(entry("roster.import", "")), undefined);
  assert.equal(shortId("ab".repeat(32)), "abababab…");
  assert.deepEqual(detailsOf({ before: "", after: '{"score":"61.500000"}' }), [
    { name: "Score", before: "", after: "61.5" },
  ]);
  assert.equal(shortId(`of ${id(12)}.`), "of …000012.");
});

test("each person whose name is needed is listed once", () => {
  assert.deepEqual(
    peopleIn([
      entry("person.edit", id(7)),
      entry("cohort.add", id(10), "{}", `{"person":"${id(8)}"}`),
      entry("attempt.seal", id(9)),
    ]),
    [id(3), id(7), id(8)],
  );
});

test("codes and answers of the server are told in words", () => {
  const told = (after: object) =>
    detailsOf({ before: "", after: JSON.stringify(after) }).map(({ name, after: text }) => [name, text]);
  assert.deepEqual(told({ state: "scored", role: "student", cause: "appeal", archived: "yes" }), [
    ["State", "Scored"],
    ["Role", "student"],
    ["Cause", "After an appeal"],
    ["Archived", "yes"],
  ]);
});
