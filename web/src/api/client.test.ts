import assert from "node:assert/strict";
import { test } from "node:test";
import { Client } from "./client";

interface Call {
  readonly path: string;
  readonly init: RequestInit;
}

function clientThatGets(answers: Array<Response | Error>) {
  const calls: Call[] = [];
  let lost = 0;
  const client = new Client(() => { ++lost; }, async (path, init) => {
    calls.push({ path, init });
    const answer = answers.shift();
    if (answer === undefined || answer instanceof Error) throw answer ?? new Error("no answer prepared");
    return answer;
  });
  return { client, calls, lost: () => lost };
}

const refusal = (status: number, code: string) =>
  new Response(JSON.stringify({ error: { code, message: `says ${code}`, field: "" } }), { status });
const session = () => Response.json({ person: { id: "p", login: "l", display_name: "P", role: "student" }, csrf: "token" });
const header = (call: Call | undefined, name: string) => (call?.init.headers as Record<string, string> | undefined)?.[name];

test("a wrong password is an error with the server's sentence and no lost session", async () => {
  const { client, lost } = clientThatGets([refusal(401, "unauthenticated")]);
  const result = await client.signIn("a", "b");
  assert.equal(!result.ok && result.error.message, "says unauthenticated");
  assert.equal(lost(), 0);
});

test("a request that finds no session any more reports it once", async () => {
  const { client, lost } = clientThatGets([refusal(401, "unauthenticated")]);
  await client.exercises();
  assert.equal(lost(), 1);
});

test("what changes something repeats the session's csrf value; sign-in and reads do not", async () => {
  const { client, calls } = clientThatGets([session(), Response.json({ exercises: [] }), new Response(null, { status: 204 })]);
  await client.signIn("a", "b");
  await client.exercises();
  await client.release("x");
  assert.equal(header(calls[0], "X-Enamel-Csrf"), undefined);
  assert.equal(header(calls[1], "X-Enamel-Csrf"), undefined);
  assert.equal(header(calls[2], "X-Enamel-Csrf"), "token");
  assert.equal(calls[2]?.init.method, "POST");
});

test("no answer, a body that is no JSON and a surface that is none are each an error, never a throw", async () => {
  const { client } = clientThatGets([new Error("refused"), new Response("<html>"), new Response("ENSF"), new Response("proxy says no", { status: 502 })]);
  const unreachable = await client.exercises();
  const html = await client.exercises();
  const surface = await client.surface("x");
  const proxy = await client.exercises();
  assert.equal(!unreachable.ok && unreachable.error.code, "unreachable");
  assert.equal(!html.ok && html.error.code, "malformed");
  assert.match(surface.ok ? "" : surface.error.message, /at least 32 bytes, found 4/);
  assert.match(proxy.ok ? "" : proxy.error.message, /status 502/);
});

test("ids and filters are escaped into the address and empty filters left out", async () => {
  const { client, calls } = clientThatGets([Response.json({}), Response.json({})]);
  await client.attempt("../session");
  await client.attempts({ cohort: "a b", exercise: undefined, limit: 5 });
  assert.equal(calls[0]?.path, "/api/v1/attempts/..%2Fsession");
  assert.equal(calls[1]?.path, "/api/v1/attempts?cohort=a+b&limit=5");
});
