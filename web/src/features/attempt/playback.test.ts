import assert from "node:assert/strict";
import { test } from "node:test";
import { Client } from "../../api/client";
import { drawTeethWith } from "../../tooth/link";
import { beginPlayback, playbackOf } from "./playback";

const nothing = () => undefined;
drawTeethWith(() => ({
  worker: { postMessage: nothing, terminate: nothing, onmessage: null, onerror: null } as unknown as Worker,
  canvas: {} as HTMLCanvasElement,
}));
const session = () => Response.json({ person: { id: "p" }, csrf: "token" });
const settled = () =>
  new Promise((resolve) => {
    setImmediate(resolve);
  });

// Of timelines, one answer after the other; signing in succeeds.
function clientThatGets(...timelines: Response[]) {
  const asked: string[] = [];
  const client = new Client(nothing, async (path) => {
    if (path.endsWith("/session")) return session();
    asked.push(path);
    return timelines.shift() ?? new Response("", { status: 503 });
  });
  return { client, asked };
}

test("a playback that was begun is given out once, and asks once", async () => {
  const { client, asked } = clientThatGets(new Response("ENTT", { status: 206 }));
  beginPlayback(client, "x");
  assert.notEqual(playbackOf(client, "y", nothing).state.state, "failed", "another attempt has its own");
  const first = playbackOf(client, "x", nothing);
  void first.load();
  await settled();
  assert.deepEqual(asked, ["/api/v1/attempts/x/timeline"]);
  assert.notEqual(playbackOf(client, "x", nothing), first);
});

test("a playback that was refused is begun again, and one of somebody else is not shown", async () => {
  const refused = clientThatGets(new Response(JSON.stringify({ error: { code: "unauthenticated" } }), { status: 401 }));
  beginPlayback(refused.client, "x");
  await settled();
  await settled();
  assert.equal(playbackOf(refused.client, "x", nothing).state.state, "loading");

  const { client } = clientThatGets(new Response("ENTT", { status: 206 }));
  let told = 0;
  beginPlayback(client, "x");
  await settled();
  assert.ok((await client.signIn("a", "b")).ok);
  void playbackOf(client, "x", () => ++told).load();
  await settled();
  assert.equal(told, 1, "it was asked for again, and the server has none");
});
