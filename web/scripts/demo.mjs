// Writes one HTML file that shows an attempt of a simulated hand as its student sees it, without a server and without
// network: the page itself, with what a running server answers about the attempt.
//   ENAMEL_PASSWORD=… node scripts/demo.mjs --server URL --login STUDENT --attempt ID --out FILE.html
// The address of Enamel's source in it is the one in CONTACT.
import { readFileSync, statSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { oneFile, write } from "./one_file.mjs";
import { bundled, imported, keysOf, kStyle, web } from "./report_parts.mjs";
import { wordsByPart } from "./words.mjs";

const kPage = "src/app/demo.tsx";
const kUsage =
  "usage: ENAMEL_PASSWORD=… node scripts/demo.mjs --server URL --login STUDENT --attempt ID --out FILE.html";
const kMaxMs = 300_000; // until the server has made the playback
const kAgainMs = 500;

// The page's client asks, and what the server answers is kept by address.
function listening(server) {
  const answers = {};
  let cookie = "";
  const send = async (path, { headers, ...init }) => {
    const { Range: _, ...sent } = headers; // the whole at once
    const answer = await fetch(new URL(path, server), { ...init, headers: { ...sent, cookie } });
    cookie = answer.headers.getSetCookie()[0]?.split(";")[0] ?? cookie;
    const bytes = Buffer.from(await answer.arrayBuffer());
    if (init.method === "GET" && answer.ok)
      answers[path] = answer.headers.get("Content-Type").startsWith("application/json")
        ? { json: JSON.parse(bytes) }
        : { base64: bytes.toString("base64") };
    return new Response(bytes.length > 0 ? bytes : null, answer);
  };
  return { answers, send };
}

async function playbackOf(client, id) {
  const end = Date.now() + kMaxMs;
  for (;;) {
    const playback = await client.stream("/attempts/{id}/timeline", [0, 1], { id });
    if (playback.ok || playback.error.code !== "unavailable" || Date.now() > end) return playback;
    await new Promise((resolve) => setTimeout(resolve, kAgainMs));
  }
}

// All that the page asks about an attempt that it shows alone. Throws where something is not there.
async function recorded({ server, login, attempt: id }, password) {
  const { Client, decodeHead } = await imported(
    'export { Client } from "./src/api/client.ts"; export { decodeHead } from "./src/tooth/timeline.ts";',
  );
  const { answers, send } = listening(server);
  const client = new Client(() => undefined, send);
  const needed = (what, { ok, value, error }) => {
    if (!ok) throw new Error(`${server}: ${what}: ${error.message}`);
    return value;
  };
  needed(`${login} cannot sign in`, await client.signIn(login, password));
  const attempt = needed(`attempt ${id}`, await client.get("/attempts/{id}", { id }));
  if (attempt.hand.kind !== "program")
    throw new Error(`attempt ${id}: expected a simulated hand, found a person's; name an attempt that no person made`);
  if (attempt.state !== "scored" || attempt.score === null)
    throw new Error(`attempt ${id}: expected a score that ${login} may see, found none; release it`);
  needed("the score", await client.score(id));
  needed("the exercise", await client.get("/exercises/{id}", { id: attempt.exercise.id }));
  needed("the forces", await client.series(id));
  needed("the remarks", await client.all("/attempts/{id}/annotations", { id }));
  needed("the earlier scores", await client.all("/attempts/{id}/results", { id }));
  const playback = needed("the playback", await playbackOf(client, id));
  const head = needed("the playback", await decodeHead(await new Response(playback).arrayBuffer()));
  needed("the tooth before it was cut", await client.bytes("/start-teeth/{name}", { name: head.start, kept: true }));
  const compared = await client.bytes("/attempts/{id}/deviation", { id, kept: true });
  if (!compared.ok && compared.error.code !== "not_found") needed("the deviation", compared);
  await client.signOut();
  return { attempt: id, person: attempt.person.id, answers };
}

function repository() {
  const text = readFileSync(join(web, "../CONTACT"), "utf8");
  return /^repository: *(https:\S+)$/m.exec(text)?.[1] ?? "";
}

export async function writeDemo({ out, ...of }, password) {
  const demo = { ...(await recorded(of, password)), repository: repository() };
  // All words of the page are in the file, so no part of it has words of its own.
  const words = wordsByPart({ first: await keysOf(kPage), closer: [], compare_search: [] });
  const [script, style, worker] = await Promise.all([
    bundled(kPage, { plugins: [words] }),
    bundled(kStyle),
    bundled("src/tooth/worker.ts", { define: { kOpenedAddress: '"./opened"' } }),
  ]);
  const file = oneFile({
    title: "Enamel: a recorded attempt",
    script,
    style,
    held: { worker, demo },
    allowed: "worker-src blob:; img-src data: blob:; ",
    icon: readFileSync(join(web, "public/favicon.svg")),
  });
  write(out, file);
}

async function main() {
  const text = { type: "string" };
  try {
    const { values } = parseArgs({ options: { server: text, login: text, attempt: text, out: text } });
    const password = process.env.ENAMEL_PASSWORD;
    if (Object.keys(values).length < 4 || password === undefined) throw new Error(kUsage);
    await writeDemo(values, password);
    console.log(`${values.out}: ${(statSync(values.out).size / 1000).toFixed(0)} kB`);
  } catch (error) {
    console.error(error.code?.startsWith("ERR_PARSE_ARGS") ? `${error.message}; ${kUsage}` : error.message);
    process.exitCode = 1;
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await main();
