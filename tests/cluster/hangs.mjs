// What run.sh does for --only hangs: faults in which nothing ends and nobody answers, while stations stream. hangs.mjs takes run.mjs's arguments.
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import http from "node:http";
import { ask, bin, database, enamel, jsonFile, linked, lostOrDoubled, missed, now, password, pg, port, postmaster, primary, promote, proxy, quantile, rejoin, run, running, say,
  section, serveOne, servers, shell, shown, size, startProxy, streams, tell, timesSaid, until, untilAllUp, untilSynchronous, work } from "./harness.mjs";

const sizes = size === "short" ? { stations: 20, minutes: 3, times: 1 } : { stations: 100, minutes: 4, times: 3 };
// Seconds: from the promotion, or from the fault, until every station is taken again; until /readyz is not "ok".
const goals = { database_stopped: 10, database_gone: 10, server_cut: 10, server_stopped: 7, ready_false: 5 };
const facts = { format: 1, size, goals };
const names = Object.keys(servers);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

// What a server answers; status 0: nothing within a second.
function get(name, path, body) {
  return new Promise((done) => {
    const headers = { Host: "enamel.test", "X-Forwarded-Proto": "https", "X-Forwarded-For": "192.0.2.1", ...(body && { "Content-Type": "application/json", Origin: "https://enamel.test" }) };
    const request = http.request({ host: servers[name], port, path, method: body ? "POST" : "GET", headers, timeout: body ? 10_000 : 1000 }, (answer) => {
      let text = "";
      answer.setEncoding("utf8").on("data", (piece) => (text += piece)).on("end", () => done({ status: answer.statusCode, text }));
    });
    request.on("error", () => done({ status: 0, text: "" })).on("timeout", () => request.destroy()).end(body);
  });
}
const isWell = ({ status, text }) => status === 200 && JSON.parse(text).status === "ok";
// Seconds from now until each of them does not say "ok".
async function untilUnwell(list) {
  const began = now();
  for (const name of list) await until(`/readyz of server ${name} is not ok`, async () => !isWell(await get(name, "/readyz")), 60);
  return now() - began;
}
const untilAllWell = () => until("every server is well", async () => (await Promise.all(names.map((name) => get(name, "/readyz")))).every(isWell));

// Chunks committed of each attempt that is being made.
const chunks = async () => new Map((await ask("SELECT encode(id, 'hex'), chunks FROM school.attempts WHERE state = 2 AND chunks > 0")).split("\n").filter(Boolean).map((row) => [row.split("|")[0], Number(row.split("|")[1])]));
async function untilTaken() {
  const before = await chunks();
  await until("every station is taken again", async () => { const after = await chunks(); return [...before].every(([id, count]) => !after.has(id) || after.get(id) > count); });
}
const signalDatabase = async (name, signal) => {
  const first = postmaster(name);
  process.kill(first, signal);
  await run("pkill", [`-${signal.slice(3)}`, "-P", String(first)]).catch(() => {});
};
const link = (machine, side, is) => execFileSync("ip", ["-n", machine, "link", "set", `eth${side}`, is]);

// Each gives seconds by name.
const faults = {
  // Its processes are stopped: connections stay open, and nothing is answered.
  database_stopped: () => primaryHangs((name) => signalDatabase(name, "SIGSTOP"), (name) => signalDatabase(name, "SIGCONT")),
  // Its machine is gone: no packet leaves it, not even one that ends a connection.
  database_gone: linked && (() => primaryHangs(async (name) => { for (const side of ["a", "b"]) link(name, side, "down"); },
    async (name) => { await shell(`postgres_end ${pg}/${name}`); for (const side of ["a", "b"]) link(name, side, "up"); })),
  server_cut: linked && (async () => {
    const down = timesSaid("one", "DOWN"), up = timesSaid("one", "UP");
    const began = now();
    for (const machine of ["one", "two"]) link(machine, "b", "down");
    const ready_false = await untilUnwell(["one"]);
    await pause(200);
    await untilTaken();
    const taken = now() - began;
    await until("HAProxy misses server one", () => timesSaid("one", "DOWN") > down);
    for (const machine of ["one", "two"]) link(machine, "b", "up");
    await until("HAProxy sends to server one again", () => timesSaid("one", "UP") > up);
    return { taken, ready_false };
  }),
  // Server one holds few stations since it was cut off: new ones come where the fewest are.
  server_stopped: async (i) => {
    const name = names[(i + 1) % names.length], down = timesSaid(name, "DOWN"), up = timesSaid(name, "UP");
    const began = now();
    running.get(name).kill("SIGSTOP");
    await pause(200);
    await untilTaken();
    const taken = now() - began;
    await until(`HAProxy misses server ${name}`, () => timesSaid(name, "DOWN") > down);
    running.get(name).kill("SIGCONT");
    await until(`HAProxy sends to server ${name} again`, () => timesSaid(name, "UP") > up);
    return { taken };
  },
};
async function primaryHangs(hang, wake) {
  await untilSynchronous();
  await untilAllWell();
  const old = primary;
  const downs = () => names.reduce((sum, name) => sum + timesSaid(name, "DOWN"), 0), before = downs();
  await hang(old);
  const ready_false = await untilUnwell(names);
  await pause(3000);
  const taken_out = downs() - before;
  const promotion = await promote(), began = now();
  await untilTaken();
  const taken = now() - began;
  await untilAllWell();
  const ready_again = now() - began;
  await wake(old);
  await rejoin();
  return { taken, ready_false, promotion, ready_again, taken_out };
}

section("three servers behind HAProxy, PostgreSQL with a synchronous standby, Swift");
await enamel("init", "--data", `${work}/one`, ...database("one"));
await enamel("seed-demo", "--data", `${work}/one`, "--voxel-um", "150");
for (const login of ["admin", "instructor", "student1", "student2"]) {
  execFileSync(`${bin}/enamel-server`, ["admin", "set-password", "--data", `${work}/one`, "--login", login, "--password-stdin"], { input: `${password}\n`, stdio: ["pipe", "ignore", "ignore"] });
}
for (const name of ["two", "three"]) await enamel("init", "--data", `${work}/${name}`, ...database(name), "--identity", `${work}/one`);
for (const name of names) await serveOne(name);
await startProxy();
// The load reads back through server two's links, which nobody takes away for long.
const stream = streams({ ...sizes, data: `${work}/two`, at: `127.0.0.1:${proxy + 1}` });
for (const [kind, fault] of Object.entries(faults)) {
  if (!fault) {
    say(`  ${kind}: skipped, which needs root and network namespaces`);
    continue;
  }
  section(`${kind}, ${sizes.times} times, while ${sizes.stations} stations stream`);
  const found = [];
  for (let i = 0; i < sizes.times; ++i) {
    await stream.ready();
    await untilAllUp();
    found.push(await fault(i));
  }
  const seconds = (name) => found.map((one) => one[name]).filter((value) => value !== undefined);
  facts[kind] = { count: found.length };
  for (const name of Object.keys(found[0]).filter((name) => name !== "taken_out")) {
    facts[kind][`${name}_s`] = seconds(name);
    facts[kind][`${name}_p95_s`] = quantile(seconds(name), 0.95);
    tell(`${kind}: ${name.replaceAll("_", " ")}, p95, s`, facts[kind][`${name}_p95_s`], name === "taken" ? goals[kind] : goals[name]);
  }
  if (found[0].taken_out === undefined) continue;
  facts[kind].taken_out = Math.max(...seconds("taken_out"));
  tell(`${kind}: servers that HAProxy took out, although all had the same trouble`, facts[kind].taken_out, 0);
}

// The database's clock is put an hour forward while stations stream: times are the median of four clocks.
const library = "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1";
section("database_clock: an hour off, once");
await stream.ready();
// In a process of PostgreSQL's user: the library's semaphores are the user's.
const faked = await shell(`[ -e ${library} ] && echo +0 >${work}/clock && chmod 644 ${work}/clock && postgres pg_ctl -D ${pg}/${primary} -m fast -w stop >/dev/null && rm -f ${pg}/${primary}.socket/.s.* &&
  postgres_as+=(env LD_PRELOAD=${library} FAKETIME_TIMESTAMP_FILE=${work}/clock FAKETIME_DONT_FAKE_MONOTONIC=1 FAKETIME_CACHE_DURATION=1) && postgres_start ${pg}/${primary} ${pg}/${primary}.socket`).then(() => true, () => false);
if (faked) {
  await untilSynchronous();
  await untilAllWell();
  await untilTaken();
  const before = Date.now();
  writeFileSync(`${work}/clock`, "+3600\n");
  const began = now(), answers = new Set();
  let refused = 0;
  while (now() - began < 15) {
    for (const name of names) {
      const answer = await get(name, "/readyz");
      if (answer.status !== 200) ++refused;
      else answers.add(JSON.parse(answer.text).status);
    }
    await pause(200);
  }
  await untilTaken();
  const signed = await get("two", "/api/v1/session", JSON.stringify({ login: "admin", password }));
  const text = (await get("two", "/readyz")).text;
  const newest = Number(await ask("SELECT max(last_chunk_ms) FROM school.attempts"));
  facts.database_clock = { refused, signed_in: signed.status, warned: /clock/.test(text), newest_chunk_off_s: Math.abs(newest - Date.now()) / 1000, for_s: (Date.now() - before) / 1000 };
  tell("database_clock: answers other than 200", refused, 0);
  tell("database_clock: a sign-in is answered with", signed.status, 299);
  tell("database_clock: /readyz warns of the clock", Number(facts.database_clock.warned), 1, true);
  tell("database_clock: the newest chunk's time is off by, s", facts.database_clock.newest_chunk_off_s, 10);
} else {
  say("  database_clock: skipped, faketime is not installed");
}

Object.assign(facts, await stream.end());
tell("ticks lost", facts.ticks_lost, 0);
tell("ticks doubled", facts.ticks_doubled, 0);
facts.missed = missed;
if (jsonFile) writeFileSync(jsonFile, `${JSON.stringify(facts, null, 1)}\n`);
say(missed.length === 0 ? "every goal is met" : `missed: ${missed.join("; ")}`);
if (lostOrDoubled > 0) console.error(`FAILED: lost, doubled, refused or changed: ${shown(lostOrDoubled)}`);
process.exit(lostOrDoubled > 0 ? 1 : 0);
