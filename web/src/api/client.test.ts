import assert from "node:assert/strict";
import { test } from "node:test";
import { askFirst, kFirstBytes } from "./ahead";
import { Client } from "./client";
import { reported } from "./http";

interface Call {
  readonly path: string;
  readonly init: RequestInit;
}

function clientThatGets(answers: Array<Response | Error>) {
  const calls: Call[] = [];
  let lost = 0;
  const send = async (path: string, init: RequestInit) => {
    calls.push({ path, init });
    const answer = answers.shift();
    if (answer === undefined || answer instanceof Error) throw answer ?? new Error("no answer prepared");
    return answer;
  };
  const client = new Client(() => {
    ++lost;
  }, send);
  return { client, calls, send, lost: () => lost };
}

const refusal = (status: number, code: string) =>
  new Response(JSON.stringify({ error: { code, message: `says ${code}`, field: "" } }), { status });
const session = () =>
  Response.json({ person: { id: "p", login: "l", display_name: "P", role: "student" }, csrf: "token" });
const header = (call: Call | undefined, name: string) =>
  (call?.init.headers as Record<string, string> | undefined)?.[name];

test("a wrong password is an error with the server's sentence and no lost session", async () => {
  const { client, lost } = clientThatGets([refusal(401, "unauthenticated")]);
  const result = await client.signIn("a", "b");
  assert.equal(!result.ok && result.error.message, "Says unauthenticated.");
  assert.equal(lost(), 0);
});

test("a request that finds no session any more reports it once", async () => {
  const { client, lost } = clientThatGets([refusal(401, "unauthenticated")]);
  await client.all("/exercises");
  assert.equal(lost(), 1);
});

test("what changes something repeats the session's csrf value; sign-in and reads do not", async () => {
  const { client, calls } = clientThatGets([
    session(),
    Response.json({ exercises: [], next: null }),
    new Response(null, { status: 204 }),
  ]);
  await client.signIn("a", "b");
  await client.all("/exercises");
  await client.post("/attempts/{id}/release", { id: "x", tag: 1 });
  assert.equal(header(calls[0], "X-Enamel-Csrf"), undefined);
  assert.equal(header(calls[1], "X-Enamel-Csrf"), undefined);
  assert.equal(header(calls[2], "X-Enamel-Csrf"), "token");
  assert.equal(calls[2]?.init.method, "POST");
  assert.equal(header(calls[2], "If-Match"), '"1"');
});

test("a changed password begins a session whose csrf value counts from then on", async () => {
  const { client, calls } = clientThatGets([
    session(),
    Response.json({ person: {}, csrf: "next" }),
    new Response(null, { status: 204 }),
  ]);
  await client.signIn("a", "b");
  await client.changePassword("b", "c");
  await client.signOut();
  assert.equal(header(calls[1], "X-Enamel-Csrf"), "token");
  assert.equal(header(calls[2], "X-Enamel-Csrf"), "next");
});

test("no answer, a body that is no JSON and all of a file where a part was asked for are each an error, never a throw", async () => {
  const { client } = clientThatGets([
    new Error("refused"),
    new Response("<html>"),
    new Response("ENTM"),
    new Response("proxy says no", { status: 502 }),
  ]);
  const unreachable = await client.all("/exercises");
  const html = await client.all("/exercises");
  const all = await client.stream("/attempts/{id}/timeline", [5, 9], { id: "x" });
  const proxy = await client.all("/exercises");
  assert.equal(!unreachable.ok && unreachable.error.code, "unreachable");
  assert.equal(!html.ok && html.error.code, "malformed");
  assert.match(all.ok ? "" : all.error.message, /all of it where a part was asked for/);
  assert.match(proxy.ok ? "" : proxy.error.message, /status 502/);
});

test("what is asked ahead is given out once, and not to whoever signs in next", async () => {
  const { client, calls, send } = clientThatGets([
    Response.json({ person: {}, csrf: "a" }),
    Response.json({ id: "x" }),
    new Response("ENTT", { status: 206 }),
    Response.json({ criteria: [] }),
    Response.json({ person: {}, csrf: "b" }),
    Response.json({ id: "x" }),
  ]);
  askFirst(client.ahead, send, "x");
  assert.equal(calls.length, 4);
  assert.ok((await client.currentSession()).ok);
  const part = await client.stream("/attempts/{id}/timeline", [0, kFirstBytes], { id: "x" });
  assert.equal(part.ok && (await new Response(part.value).text()), "ENTT");
  assert.equal(calls.length, 4);
  assert.ok((await client.signIn("a", "b")).ok);
  assert.ok((await client.get("/attempts/{id}", { id: "x" })).ok);
  assert.equal(calls.length, 6, "the attempt was asked for again");
});

test("what was not there yet when it was asked ahead is asked again", async () => {
  const { client, calls, send } = clientThatGets([
    Response.json({ person: {}, csrf: "a" }),
    Response.json({ id: "x" }),
    new Response("ENTT", { status: 206 }),
    Response.json({ error: { code: "conflict", message: "this one is scoring" } }, { status: 409 }),
    Response.json({ score: 94, criteria: [] }),
  ]);
  askFirst(client.ahead, send, "x");
  const score = await client.score("x");
  assert.equal(score.ok && score.value.score, 94);
  assert.equal(calls.length, 5);
});

test("what was read ahead is given out once, for its own attempt, and asked again where it failed", async () => {
  const series = () =>
    Response.json({
      rate_hz: 1000,
      step_ticks: 24,
      t_s: [0],
      force_n: [0],
      force_mean_n: [0],
      computed_n: [0],
      late_ticks: [0],
      bound_n: [0],
      removed_mm3: [0],
      removed_by_tissue: {},
      anchor_mm: [[0, 0, 0]],
      force_vector_n: [[0, 0, 0]],
    });
  const { client, calls } = clientThatGets([series(), series(), series(), new Error("lost"), series()]);
  client.readAhead("a");
  client.readAhead("a");
  assert.ok((await client.series("a")).ok);
  assert.equal(calls.length, 1);
  assert.ok((await client.series("a")).ok);
  assert.ok((await client.series("b")).ok);
  assert.equal(calls.length, 3);
  client.readAhead("c");
  assert.ok((await client.series("c")).ok);
  assert.equal(calls.length, 5, "it had failed and was asked again");
});

test("ids and filters are escaped into the address and empty filters left out", async () => {
  const { client, calls } = clientThatGets([Response.json({}), Response.json({})]);
  await client.get("/attempts/{id}", { id: "../session" });
  await client.page("/attempts", { cohort: "a b", exercise: undefined, limit: 5 });
  assert.equal(calls[0]?.path, "/api/v1/attempts/..%2Fsession");
  assert.equal(calls[1]?.path, "/api/v1/attempts?cohort=a+b&limit=5");
});

test("a change that needs the password again is sent once more after it was given, and only then", async () => {
  const { client, calls } = clientThatGets([
    refusal(403, "confirm_password"),
    Response.json({ id: "p", password: "once" }),
    refusal(403, "confirm_password"),
    refusal(403, "confirm_password"),
    refusal(403, "confirm_password"),
  ]);
  let asked = 0;
  client.confirm = async () => {
    ++asked;
    return true;
  };
  const reset = await client.post("/people/{id}/password", { id: "p" });
  assert.equal(reset.ok && reset.value.password, "once");
  assert.deepEqual(
    calls.map((call) => call.path),
    ["/api/v1/people/p/password", "/api/v1/people/p/password"],
  );
  const still = await client.post("/people/{id}/password", { id: "p" });
  assert.equal(!still.ok && still.error.code, "confirm_password");
  assert.equal(asked, 2);
  client.confirm = async () => false;
  const refused = await client.post("/people/{id}/password", { id: "p" });
  assert.equal(!refused.ok && refused.error.code, "confirm_password");
  assert.equal(calls.length, 5);
});

test("an edit repeats the tag it was read with, and a conflict carries what somebody else saved", async () => {
  const stale = new Response(
    JSON.stringify({
      error: { code: "precondition_failed", message: "m", field: "revision" },
      current: { name: "theirs" },
    }),
    { status: 412, headers: { ETag: '"8"' } },
  );
  const { client, calls } = clientThatGets([stale]);
  const result = await client.tagged("PATCH", "/cohorts/{id}", { id: "c", body: { name: "mine" }, tag: '"7"' });
  assert.equal(header(calls[0], "If-Match"), '"7"');
  assert.equal(calls[0]?.init.method, "PATCH");
  assert.deepEqual(!result.ok && result.error.current, { value: { name: "theirs" }, tag: '"8"' });
});

test("a list gives its rows and the next cursor, and one without rows is an error", async () => {
  const { client, calls } = clientThatGets([
    Response.json({ people: [{ id: "a" }], next: "c2" }),
    Response.json({ people: [{ id: "b" }], next: null }),
    Response.json({ people: {} }),
  ]);
  const first = await client.page("/people", { text: "x", cohort: "" });
  assert.ok(first.ok && first.value.next === "c2" && first.value.items.length === 1);
  assert.equal(calls[0]?.path, "/api/v1/people?text=x");
  assert.ok((await client.page("/people", { cursor: "c2" })).ok);
  const wrong = await client.page("/people");
  assert.equal(!wrong.ok && wrong.error.code, "malformed");
});

test("what a screen shows as a whole is read to its last page", async () => {
  const rows = (first: number, count: number) => Array.from({ length: count }, (_, i) => ({ id: first + i }));
  const { client, calls } = clientThatGets([
    Response.json({ exercises: rows(0, 200), next: "c2" }),
    Response.json({ exercises: rows(200, 200), next: "c3" }),
    Response.json({ exercises: rows(400, 1), next: null }),
  ]);
  const result = await client.all("/exercises", { state: "draft" });
  assert.equal(result.ok && result.value.length, 401);
  const asked = (name: string) => calls.map((call) => new URL(call.path, "http://localhost").searchParams.get(name));
  assert.deepEqual(asked("cursor"), [null, "c2", "c3"]);
  assert.deepEqual(asked("state"), ["draft", "draft", "draft"]);
});

test("a list of which a page is refused is an error, not a part of it", async () => {
  const { client } = clientThatGets([
    Response.json({ versions: [{ id: "a" }], next: "c2" }),
    refusal(503, "unavailable"),
  ]);
  const result = await client.all("/exercises/{id}/versions", { id: "x" });
  assert.equal(!result.ok && result.error.code, "unavailable");
});

test("a state that everybody meets is said in words, whatever the server's sentence", async () => {
  const answer = { error: { code: "conflict", message: "expected X, found Y", field: "marking_given_up" } };
  const { client } = clientThatGets([new Response(JSON.stringify(answer), { status: 409 })]);
  const result = await client.delete("/markings/{id}", { id: "m" });
  assert.equal(!result.ok && result.error.message, "This blind marking was given up. Nothing can be marked any more.");
});

test("a refusal that says what is wrong is a report, not an error; any other is one", async () => {
  const { client } = clientThatGets([
    new Response(
      JSON.stringify({
        error: { code: "invalid_input", message: "m", field: "body" },
        problems: [{ row: 2 }],
        problem_count: 1,
      }),
      { status: 400 },
    ),
    refusal(415, "unsupported_media_type"),
  ]);
  const ask = () => reported(client.post("/roster", { body: "", type: "text/csv" }), "problems");
  const report = await ask();
  assert.ok(report.ok && report.value.problem_count === 1);
  assert.ok(!(await ask()).ok);
});
