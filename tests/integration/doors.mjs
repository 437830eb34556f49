// What doors.sh measures: doors.mjs PORT PID ATTEMPT SECONDS JSON
import { readFileSync, writeFileSync } from "node:fs";
import http from "node:http";

const [port, pid, attempt, seconds, jsonFile] = process.argv.slice(2);
const forS = Number(seconds);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const now = () => performance.now();
let failed = 0;
const tell = (text, bad) => { console.log(`${bad ? "FAILED" : "ok"}: ${text}`); failed += bad ? 1 : 0; };

// One request on a connection of its own unless `agent` keeps it; gives status and bytes, status 0: no answer.
function ask(path, { method = "GET", cookie, body, from, agent = false } = {}) {
  return new Promise((done) => {
    const headers = { Host: `127.0.0.1:${port}`, Origin: `http://127.0.0.1:${port}`, ...(cookie && { Cookie: cookie }), ...(body && { "Content-Type": "application/json" }) };
    const request = http.request({ host: "127.0.0.1", port, path, method, headers, agent, ...(from && { localAddress: from }) }, (answer) => {
      let bytes = 0;
      answer.on("data", (piece) => (bytes += piece.length)).on("end", () => done({ status: answer.statusCode, bytes, cookie: answer.headers["set-cookie"]?.[0].split(";")[0] })).on("error", () => done({ status: 0 }));
    });
    request.on("error", () => done({ status: 0 })).end(body);
  });
}
const signIn = (login, password, from) => ask("/api/v1/session", { method: "POST", body: JSON.stringify({ login, password }), from });
const cookieOf = async (login) => {
  const { status, cookie } = await signIn(login, `enamel-demo-${login}`);
  if (status >= 300) throw new Error(`${login} cannot sign in: ${status}`);
  return cookie;
};
const quantile = (values, p) => [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.ceil(p * values.length) - 1)];

// What others do meanwhile: one request after another, as a page does.
async function others(cookie, paths, until) {
  const took = [];
  let refused = 0;
  for (let i = 0; until(); ++i) {
    const began = now();
    const { status } = await ask(paths[i % paths.length], { cookie });
    took.push(now() - began);
    if (status === 0 || status === 429 || status >= 500) ++refused;
    await pause(20);
  }
  return { requests: took.length, refused, p50_ms: quantile(took, 0.5), p99_ms: quantile(took, 0.99) };
}

const greedy = await cookieOf("student1"), other = await cookieOf("student2"), teacher = await cookieOf("instructor");
const surface = `/api/v1/attempts/${attempt}/surface`;
const { status, bytes } = await ask(surface, { cookie: greedy });
if (status !== 200) throw new Error(`the surface cannot be read: ${status}`);
const pages = ["/api/v1/session", "/api/v1/attempts"];
const facts = { format: 1, surface_bytes: bytes };

// Eighty connections of one student; another student's requests, and an instructor who looks at the same surface.
const shown = ({ requests, refused, p50_ms, p99_ms }) => `${refused} of ${requests} refused, p50 ${Math.round(p50_ms)} ms, p99 ${Math.round(p99_ms)} ms`;
{
  let on = true;
  const flood = Array.from({ length: 80 }, async () => { while (on) await ask(surface, { cookie: greedy, agent: new http.Agent({ keepAlive: true }) }); });
  await pause(500);
  const began = now(), until = () => now() - began < forS * 1000;
  [facts.flood, facts.flood_same_surface] = await Promise.all([others(other, pages, until), others(teacher, [surface], until)]);
  on = false;
  await Promise.all(flood);
  tell(`80 connections of one student ask for ${(bytes / 1e6).toFixed(1)} MB: another's requests: ${shown(facts.flood)}`, facts.flood.refused > 0);
  tell(`an instructor's for the same surface: ${shown(facts.flood_same_surface)}`, facts.flood_same_surface.refused > 0);
}

// Sixty connections that read nothing.
const resident = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8"))[1]) / 1024;
{
  const before = resident();
  const slow = Array.from({ length: 60 }, () => {
    const request = http.request({ host: "127.0.0.1", port, path: surface, headers: { Host: `127.0.0.1:${port}`, Cookie: greedy }, agent: false }, (answer) => answer.pause());
    request.on("error", () => {}).end();
    return request;
  });
  await pause(1000);
  const began = now();
  facts.slow = await others(other, pages, () => now() - began < 1000);
  facts.slow.resident_mib = resident();
  for (const request of slow) request.destroy();
  const most = before + 3 * bytes / (1 << 20) + 32;
  tell(`60 connections of one student read nothing: another's requests: ${shown(facts.slow)}; resident ${Math.round(facts.slow.resident_mib)} MiB, ${Math.round(before)} before`,
    facts.slow.refused > 0 || facts.slow.resident_mib > most);
}

// Three addresses guess the passwords of many; six owners sign in at once from an address that is new, and again.
{
  let on = true, guesses = 0;
  const guessers = ["127.0.0.2", "127.0.0.3", "127.0.0.4"].flatMap((from) => Array.from({ length: 30 }, async (_, i) => {
    for (let n = 0; on; ++n) { await signIn(`guess-${i}-${n}`, "guess", from); ++guesses; await pause(5); }
  }));
  await pause(500);
  const owners = [...["student1", "student2", "instructor", "admin"].map((login) => [login, `enamel-demo-${login}`]), ["anna", "a quite unlikely password 7"], ["ben", "a quite unlikely password 7"]];
  facts.sign_in = {};
  for (const round of ["new", "known"]) {
    const began = now();
    const answers = await Promise.all(owners.map(([login, password]) => signIn(login, password, "127.0.0.9")));
    const refused = answers.filter(({ status }) => status !== 200).length;
    facts.sign_in[round] = { owners: owners.length, refused, longest_ms: now() - began };
    tell(`three addresses guess: of ${owners.length} owners at once from an address that is ${round} ${refused} refused, the last in after ${Math.round(now() - began)} ms`, refused > 0);
  }
  on = false;
  await Promise.all(guessers);
  facts.sign_in.guesses = guesses;
}
if (jsonFile) writeFileSync(jsonFile, `${JSON.stringify(facts, null, 1)}\n`);
process.exit(failed > 0 ? 1 : 0);
