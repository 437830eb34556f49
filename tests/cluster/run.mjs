// The work of run.sh: run.mjs SIZE SERVER_PORT PROXY_PORT PARTS JSON_FILE, with PostgreSQL in ENAMEL_PG and Swift running.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import http from "node:http";
import { addLost, ask, bin, clusterPids, cpuOf, enamel, jsonFile, jsonOf, load, lostOrDoubled, missed, moveToCluster, now, partsOf, parts, password, port, postmaster, primary, promote,
  proxy, quantile, rejoin, run, running, say, section, serve, serveOne, servers, setAway, shown, size, start, startProxy, stop, streams, tell, timesSaid, until,
  untilSynchronous, work } from "./harness.mjs";

const short = size === "short";
const sizes = short
  ? { stations: 60, minutes: 0.2, faultStations: 40, faultMinutes: 0.5, faults: { server: 3, proxy: 1, blobs: 1, primary: 1 }, rollingStations: 40, rollingMinutes: 0.5, watchS: 5, attempts: 3, rounds: 1, workers: 2, kills: 2 }
  : { stations: 1000, minutes: 2, faultStations: 200, faultMinutes: 4, faults: { server: 200, frozen: 5, proxy: 20, blobs: 20, primary: 20 }, rollingStations: 200, rollingMinutes: 1, watchS: 30, attempts: 25, rounds: 8, workers: 4, kills: Infinity };
const goals = { commit_p99_ratio: 4, cpu_ratio: 3, recovery_p95_s: 5, moments_per_s: 50, watch_lag_p95_s: 1.5 };
const facts = { format: 1, size, goals };

// --- one server with SQLite, and what is scored there
section("one server, SQLite");
const folder = `${work}/sqlite`;
await enamel("init", "--data", folder);
await enamel("seed-demo", "--data", folder, "--voxel-um", "150", "--json", `${work}/seed`);
const exercise = jsonOf(`${work}/seed`).exercise;
for (const login of ["admin", "instructor", "student1", "student2"]) {
  execFileSync(`${bin}/enamel-server`, ["admin", "set-password", "--data", folder, "--login", login, "--password-stdin"], { input: `${password}\n`, stdio: ["pipe", "ignore", "ignore"] });
}
await serve("sqlite", folder, "127.0.0.1");
const station = `${work}/station`;
const code = (await enamel("admin", "enrol-code", "--data", folder)).stdout.trim();
await run(`${bin}/enamel-station`, ["enrol", "--data", station, "--server", `127.0.0.1:${port + 1}`, "--code", code, "--name", "run"]);
// An attempt as fast as it can be computed; gives its id.
async function attempt(user, operator, more = []) {
  const file = `${work}/cut.json`;
  await run(`${bin}/enamel-station`, ["run", "--data", station, "--profile", "phantom_desktop", "--lockstep", "--quiet", "--exercise", exercise,
    "--user", user, "--operator", operator, "--json", file, ...more], { env: { ...process.env, ENAMEL_PASSWORD: password }, maxBuffer: 1 << 26 });
  return jsonOf(file).attempt_id;
}
const scoreOf = async (data, id) => {
  await enamel("report", "--data", data, "--attempt", id, "--wait", "900", "--json", `${work}/report.json`);
  return jsonOf(`${work}/report.json`).score;
};
const logBytes = async () => Number(await ask("SELECT pg_current_wal_insert_lsn() - '0/0'"));
const wants = (part) => parts.split(",").includes(part);
const scores = new Map();
if (wants("jobs")) {
  start("worker", `${bin}/enamel-server`, ["work", "--data", folder, "--threads", "1"]);
  const reference = await attempt("instructor", "dentist", ["--as-reference"]);
  await scoreOf(folder, reference);
  await enamel("admin", "mark-reference", "--data", folder, "--attempt", reference, "--dentist", "Simulated dentist", "--consent");
  const operators = ["good", "student", "student-deep-mesial", "dentist"];
  for (let i = 0; i < sizes.attempts; ++i) {
    const id = await attempt(i % 2 ? "student2" : "student1", operators[i % operators.length], ["--seed", String(i)]);
    scores.set(id, await scoreOf(folder, id));
  }
  await stop("worker");
}
let alone;
if (wants("load")) {
  alone = await load("load-sqlite", folder, `127.0.0.1:${port + 1}`, sizes, [running.get("sqlite").pid]).facts;
  say(`  ${alone.stations} stations for ${alone.seconds} s: commit p99 ${shown(alone.commit_p99_ms)} ms, ${shown(alone.server_cpu_s_per_mtick)} CPU s per million ticks`);
}
await stop("sqlite");

// --- the same school on three servers
const stationsAt = await moveToCluster(folder);
if (wants("load")) {
  const stream = load("load-cluster", `${work}/one`, stationsAt, sizes, clusterPids());
  await stream.streams;
  // In the middle of it: not what begins and ends it.
  const logFrom = await logBytes();
  const cpu = () => Object.fromEntries(Object.entries(partsOf()).map(([part, pids]) => [part, cpuOf(pids)]));
  const from = cpu(), fromS = now();
  await new Promise((done) => setTimeout(done, sizes.minutes * 60_000 - 2000));
  const streamed = (await logBytes()) - logFrom;
  const to = cpu(), mticks = (sizes.stations * (now() - fromS)) / 1000;
  const byPart = Object.fromEntries(Object.keys(to).map((part) => [part, (to[part] - from[part]) / mticks]));
  const cluster = await stream.facts;
  const log = [streamed / 1e6 / mticks, ((await logBytes()) - logFrom) / cluster.ticks_sent];
  // A page that was written before a checkpoint is logged whole when its chunks are deleted.
  const meets = load("load-checkpoint", `${work}/one`, stationsAt, { stations: sizes.stations, minutes: 0.1 }, []);
  await meets.streams;
  const meetsFrom = await logBytes();
  await new Promise((done) => setTimeout(done, 5000));
  await ask("CHECKPOINT");
  const met = await meets.facts;
  log.push(((await logBytes()) - meetsFrom) / met.ticks_sent);
  say(`  ${cluster.stations} stations for ${cluster.seconds} s: commit p99 ${shown(cluster.commit_p99_ms)} ms, ${shown(cluster.server_cpu_s_per_mtick)} CPU s per million ticks, every process but the stations'`);
  facts.load = { sqlite: alone, cluster, commit_p99_ratio: cluster.commit_p99_ms / alone.commit_p99_ms,
    cpu_ratio: cluster.server_cpu_s_per_mtick / alone.server_cpu_s_per_mtick, cpu_s_per_mtick_by_part: byPart, log_bytes_per_tick: { streaming: log[0], sealed: log[1], checkpointed: log[2] } };
  say(`  of which ${Object.entries(byPart).map(([part, cpu]) => `${part} ${shown(cpu)}`).join(", ")}`);
  say(`  PostgreSQL's log: ${shown(log[0])} bytes a tick while stations stream, ${shown(log[1])} until they are sealed, ${shown(log[2])} where a checkpoint comes before the seal`);
  tell("ticks lost", cluster.ticks_lost, 0);
  tell("ticks doubled", cluster.ticks_doubled, 0);
  tell("commit p99, times SQLite's", facts.load.commit_p99_ratio, goals.commit_p99_ratio);
  tell("CPU per million ticks, times SQLite's", facts.load.cpu_ratio, goals.cpu_ratio);
}

// --- faults, while stations stream
// Every attempt that is being made has had a chunk committed since: until then somebody waits.
const databaseMs = async () => Number(await ask("SELECT (extract(epoch FROM clock_timestamp()) * 1000)::bigint"));
const allSince = (ms) => async () => {
  try { return (await ask(`SELECT count(*) FROM school.attempts WHERE state = 2 AND chunks > 0 AND last_chunk_ms <= ${ms}`)) === "0"; } catch { return false; }
};
async function recovery(fault, back = fault) {
  await fault();
  const began = now(), ms = await databaseMs();
  if (back !== fault) await back();
  await until("every station is taken again", allSince(ms));
  return now() - began;
}
const faults = {
  server: async (i) => {
    const name = Object.keys(servers)[i % 3];
    const took = await recovery(() => stop(name, "SIGKILL"));
    await serveOne(name);
    return took;
  },
  // As a machine that hangs: nothing is closed, and nobody answers.
  frozen: async (i) => {
    const name = Object.keys(servers)[i % 3], down = timesSaid(name, "DOWN"), up = timesSaid(name, "UP");
    const took = await recovery(() => running.get(name).kill("SIGSTOP"));
    await until(`HAProxy misses server ${name}`, () => timesSaid(name, "DOWN") > down);
    running.get(name).kill("SIGCONT");
    await until(`HAProxy sends to server ${name} again`, () => timesSaid(name, "UP") > up);
    return took;
  },
  proxy: () => recovery(() => stop("haproxy", "SIGKILL"), startProxy),
  // From its return until what was sealed meanwhile is sealed.
  blobs: async (i) => {
    const few = load(`sealing-${i}`, `${work}/one`, stationsAt, { stations: 3, minutes: 0.05 }, []);
    await few.streams;
    const before = Number(await ask("SELECT count(*) FROM school.attempts WHERE sealed_ms > 0"));
    setAway(true);
    await new Promise((done) => setTimeout(done, 6000));
    setAway(false);
    const began = now();
    await until("sealed", async () => Number(await ask("SELECT count(*) FROM school.attempts WHERE sealed_ms > 0")) >= before + 3);
    const took = now() - began;
    await few.facts;
    return took;
  },
  primary: async () => {
    await untilSynchronous();
    process.kill(postmaster(primary), "SIGKILL");
    const began = now();
    await promote();
    const ms = await databaseMs();
    await until("every station is taken again", allSince(ms));
    const took = now() - began;
    await rejoin();
    return took;
  },
};
if (wants("faults")) {
  const list = Object.entries(sizes.faults).flatMap(([kind, count]) => Array.from({ length: count }, (_, i) => [kind, i]));
  section(`faults while ${sizes.faultStations} stations stream: ${Object.entries(sizes.faults).map(([kind, count]) => `${count} of ${kind}`).join(", ")}`);
  const took = Object.fromEntries(Object.keys(sizes.faults).map((kind) => [kind, []]));
  const stream = streams({ stations: sizes.faultStations, minutes: sizes.faultMinutes, data: `${work}/one`, at: stationsAt });
  for (const [n, [kind, i]] of list.entries()) {
    await stream.ready();
    took[kind].push(await faults[kind](i));
    if (n % 20 === 19) say(`  ${n + 1} of ${list.length} faults (after ${Math.round(now())} s)`);
  }
  const { ticks_lost: lost, ticks_doubled: doubled } = await stream.end();
  facts.faults = { ticks_lost: lost, ticks_doubled: doubled };
  for (const [kind, seconds] of Object.entries(took)) {
    facts.faults[kind] = { count: seconds.length, recovery_s: seconds, recovery_p95_s: quantile(seconds, 0.95) };
    tell(`${kind}: recovery p95, s`, facts.faults[kind].recovery_p95_s, kind === "frozen" ? undefined : goals.recovery_p95_s);
  }
  tell("ticks lost", lost, 0);
  tell("ticks doubled", doubled, 0);
}

// --- a new version: every server stopped and started again, one after another, while stations stream
async function rolling() {
  const stream = load("rolling", `${work}/one`, stationsAt, { stations: sizes.rollingStations, minutes: sizes.rollingMinutes }, []);
  await stream.streams;
  await until("all stations stream", async () => Number(await ask("SELECT count(*) FROM school.attempts WHERE state = 2 AND chunks > 0")) >= sizes.rollingStations);
  for (const name of Object.keys(servers)) {
    const before = timesSaid(name, "UP");
    await stop(name);
    await serveOne(name);
    await until(`HAProxy sends to server ${name} again`, () => timesSaid(name, "UP") > before);
  }
  const while_ms = await databaseMs();
  await until("every station is taken", allSince(while_ms));
  const found = await stream.facts;
  facts.rolling = { stations: found.stations, refused_chunks: found.refused_chunks, reconnects: found.reconnects, ticks_lost: found.ticks_lost, ticks_doubled: found.ticks_doubled };
  tell("chunks refused", found.refused_chunks, 0);
  tell("ticks lost", found.ticks_lost, 0);
  tell("ticks doubled", found.ticks_doubled, 0);
  addLost(found.refused_chunks);
}

// --- jobs, with workers that die
async function jobsThatDie() {
  const jobs = sizes.attempts * sizes.rounds;
  const work1 = (i) => start(`worker-${i}`, `${bin}/enamel-server`, ["work", "--data", `${work}/one`, "--threads", "1"]);
  const list = [...scores.keys()].map((id) => `decode('${id.replaceAll("-", "")}', 'hex')`).join(", ");
  const runsOf = async () => Number(await ask(`SELECT count(*) FROM school.attempt_results WHERE attempt IN (${list})`));
  const before = await runsOf();
  for (let i = 0; i < sizes.workers; ++i) work1(i);
  let next = 0, kills = 0;
  // A job whose worker has died three times has failed: where machines are slow, endless kills would come to that.
  const killing = setInterval(async () => { if (next >= sizes.kills) return; const i = next++ % sizes.workers; await stop(`worker-${i}`, "SIGKILL"); ++kills; work1(i); }, 2000);
  const began = now();
  for (let round = 0; round < sizes.rounds; ++round) {
    await enamel("rescore", "--data", `${work}/one`, "--cohort", "Demo cohort");
    await until("scored", async () => (await ask(`SELECT count(*) FROM school.jobs WHERE attempt IN (${list}) AND state IN ('queued', 'running')`)) === "0", 1800);
  }
  clearInterval(killing);
  for (let i = 0; i < sizes.workers; ++i) await stop(`worker-${i}`, "SIGKILL");
  const after = await runsOf();
  let different = 0;
  for (const [id, score] of scores) different += (await scoreOf(`${work}/one`, id)) === score ? 0 : 1;
  const made = after - before;
  facts.jobs = { jobs, results: made, kills, scores_different: different, seconds: now() - began };
  tell("results lost", Math.max(0, jobs - made), 0);
  tell("results doubled", Math.max(0, made - jobs), 0);
  tell("scores that are not SQLite's to the bit", different, 0);
  say(`  workers killed: ${kills}, in ${shown(facts.jobs.seconds)} s`);
  addLost(Math.abs(made - jobs) + different);
}
// Neither is timed: in one, they take less.
const both = [wants("rolling") && [`each server replaced in turn while ${sizes.rollingStations} stations stream`, rolling],
  wants("jobs") && [`${sizes.attempts * sizes.rounds} jobs, ${sizes.workers} workers, one killed every 2 s${short ? `, ${sizes.kills} times` : ""}`, jobsThatDie]].filter(Boolean);
if (both.length > 0) {
  section(both.map(([what]) => what).join("; "));
  await Promise.all(both.map(([, part]) => part()));
}

// --- watching at a server that the station is not at
function atServer(name, path, { method = "GET", headers = {}, body, each } = {}) {
  return new Promise((done, failed) => {
    const request = http.request({ host: servers[name], port, path, method, headers: { Host: "enamel.test", "X-Forwarded-Proto": "https", "X-Forwarded-For": "192.0.2.1", ...headers } }, (response) => {
      let text = "";
      response.setEncoding("utf8").on("data", (piece) => (each ? each(piece) : (text += piece))).on("end", () => done({ status: response.statusCode, headers: response.headers, text })).on("error", failed);
    });
    request.on("error", failed);
    if (each) setTimeout(() => { request.destroy(); done({}); }, sizes.watchS * 1000);
    request.end(body);
  });
}
if (wants("watch")) {
  section("watching across servers");
  // A failover may just have been.
  const signed = await until("signing in", async () => {
    const answer = await atServer("one", "/api/v1/session", { method: "POST", headers: { "Content-Type": "application/json", Origin: "https://enamel.test" }, body: JSON.stringify({ login: "admin", password }) });
    return answer.status < 300 && answer;
  });
  const cookie = signed.headers["set-cookie"][0].split(";")[0];
  const stream = load("watched", `${work}/one`, stationsAt, { stations: 3, minutes: (sizes.watchS + 10) / 60 }, []);
  await stream.streams;
  const id = await until("an attempt", async () => (await ask("SELECT id::text FROM (SELECT encode(id, 'hex')::uuid AS id FROM school.attempts WHERE state = 2 AND chunks > 2 LIMIT 1) a")) || null);
  // When its first tick was due: the commit of a chunk comes soon after its last tick.
  let began = Infinity;
  const look = setInterval(async () => {
    const [chunks, ms] = (await ask(`SELECT chunks, last_chunk_ms FROM school.attempts WHERE id = decode(replace('${id}', '-', ''), 'hex')`)).split("|").map(Number);
    began = Math.min(began, ms - chunks * 500);
  }, 100);
  const rates = [], lags = [];
  await Promise.all(Object.keys(servers).map(async (name) => {
    let moments = 0, buffer = "";
    const seen = [];
    await atServer(name, `/api/v1/attempts/${id}/live`, { headers: { Cookie: cookie }, each: (piece) => {
      const at = Date.now();
      buffer += piece;
      const lines = buffer.split("\n");
      buffer = lines.pop();
      for (const line of lines) {
        if (!line.startsWith("data:")) continue;
        const data = JSON.parse(line.slice(5));
        moments += data.rows?.length ?? 0;
        if (data.tick !== undefined) seen.push(at - data.tick);
      }
    } });
    rates.push(moments / sizes.watchS);
    lags.push(...seen.map((start) => (start - began) / 1000));
  }));
  clearInterval(look);
  await stream.facts;
  facts.watch = { moments_per_s: rates, moments_per_s_least: Math.min(...rates), lag_p95_s: quantile(lags, 0.95) };
  tell("moments a second, the least of the servers", facts.watch.moments_per_s_least, goals.moments_per_s, true);
  tell("lag p95, s", facts.watch.lag_p95_s, goals.watch_lag_p95_s);
}

facts.missed = missed;
facts.lost_or_doubled = lostOrDoubled;
if (jsonFile) writeFileSync(jsonFile, `${JSON.stringify(facts, null, 1)}\n`);
say(missed.length === 0 ? "every goal is met" : `missed: ${missed.join("; ")}`);
if (lostOrDoubled > 0) console.error(`FAILED: lost, doubled, refused or changed: ${lostOrDoubled}`);
// It does not wait for what still runs.
process.exit(lostOrDoubled > 0 ? 1 : 0);
