// What run.mjs and hangs.mjs share: programs that run and are ended, the cluster, what is asked of it and how it is told.
import { execFile, execFileSync, spawn } from "node:child_process";
import { createWriteStream, readFileSync, readdirSync, writeFileSync } from "node:fs";
import net from "node:net";
import { once } from "node:events";
import { promisify } from "node:util";

export const [size, portText, proxyText, parts, jsonFile] = process.argv.slice(2);
export const port = Number(portText), proxy = Number(proxyText);
export const { ENAMEL_PG: pg, ENAMEL_WORK: work, ENAMEL_ROOT: root, ENAMEL_BIN: bin, ENAMEL_PAGE: page } = process.env;
export const run = promisify(execFile);
export const now = () => performance.now() / 1000;
export const say = (text) => console.log(text);
export const section = (text) => say(`${text} (after ${Math.round(now())} s)`);
export let lostOrDoubled = 0;
export const addLost = (count) => { lostOrDoubled += count; };

export const quantile = (values, p) => {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.length === 0 ? null : sorted[Math.min(sorted.length - 1, Math.ceil(p * sorted.length) - 1)];
};
export const shown = (value) => (value === null ? "none" : Number(value.toPrecision(3)));
// tell NAME VALUE [GOAL [UNIT]]
export const missed = [];
export function tell(name, value, goal, atLeast = false) {
  const bad = goal !== undefined && (value === null || (atLeast ? value < goal : value > goal));
  if (bad) missed.push(name);
  say(`  ${name}: ${shown(value)}${goal === undefined ? "" : ` (${atLeast ? "at least" : "at most"} ${goal})${bad ? "  MISSED" : ""}`}`);
}
export async function until(what, ask, withinS = 180) {
  const end = now() + withinS;
  for (;;) {
    const found = await ask();
    if (found) return found;
    if (now() > end) throw new Error(`${what}: not within ${withinS} s`);
    await new Promise((done) => setTimeout(done, 20));
  }
}

// PostgreSQL: which of the two is the primary, and what is asked of it.
export let primary = "one";
export const setPrimary = (name) => { primary = name; };
export const shell = (script) => run("bash", ["-c", `. ${root}/tests/support/postgres_server.sh; postgres_user ${pg}; ${script}`]);
export const ask = async (sql, name = primary) => (await run("psql", ["-X", "-A", "-t", "-d", `host=${pg}/${name}.socket user=enamel dbname=enamel`, "-c", sql])).stdout.trim();
export const postmaster = (name) => Number(readFileSync(`${pg}/${name}/postmaster.pid`, "utf8").split("\n")[0]);

// The S3 store behind a port of our own, so that it can be away.
const s3 = new URL(process.env.ENAMEL_S3_ENDPOINT);
const through = new Set();
let away = false;
const s3Port = net.createServer((from) => {
  if (away) return from.destroy();
  const to = net.connect(Number(s3.port), s3.hostname);
  for (const [a, b] of [[from, to], [to, from]]) {
    through.add(a);
    a.on("error", () => {}).on("close", () => { through.delete(a); b.destroy(); });
    a.pipe(b);
  }
});
s3Port.listen(0, "127.0.0.1");
await once(s3Port, "listening");
export const setAway = (is) => { away = is; if (is) for (const socket of through) socket.destroy(); };

// Over sockets in a folder, or over links (links.sh): server one has a link of its own to each database machine.
export const linked = Boolean(process.env.ENAMEL_LINKS);
const hostsFor = (name) => (linked ? (name === "one" ? "192.0.2.6,192.0.2.14" : "192.0.2.2,192.0.2.10") : `${pg}/one.socket,${pg}/two.socket`);
export const database = (name) => ["--database", `host=${hostsFor(name)} user=enamel dbname=enamel${linked ? ` sslmode=verify-full sslrootcert=${work}/pg.crt` : ""}`,
  "--schema", "school", "--s3-endpoint", `http://127.0.0.1:${s3Port.address().port}`, "--s3-bucket", "blobs", "--s3-region", "us-east-1",
  "--key-bucket", "keys", "--master-key", `${work}/master.key`];
export const password = "a quite unlikely password 7";
export const enamel = (...args) => run(`${bin}/enamel-server`, args, { maxBuffer: 1 << 26 });
export const jsonOf = (file) => JSON.parse(readFileSync(file, "utf8"));

// Programs that run, each ended at the end.
export const running = new Map();
// Also where a part has failed.
process.on("exit", () => { for (const child of running.values()) child.kill("SIGKILL"); });
for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => process.exit(1));
export function start(name, program, args, env = {}) {
  const log = createWriteStream(`${work}/${name}.log`, { flags: "a" });
  const child = spawn(program, args, { stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, ...env } });
  child.stdout.pipe(log);
  child.stderr.pipe(log);
  child.ended = once(child, "exit");
  running.set(name, child);
  return child;
}
export async function stop(name, signal = "SIGTERM") {
  const child = running.get(name);
  if (!child) return;
  running.delete(name);
  child.kill(signal);
  await child.ended;
}
export const servers = { one: "127.0.0.1", two: "127.0.0.2", three: "127.0.0.3" };
export async function serve(name, data, address, behind = []) {
  const child = start(name, `${bin}/enamel-server`, ["serve", "--data", data, "--http", `${address}:${port}`, "--stations", `${address}:${port + 1}`,
    "--web", page, "--job-threads", "0", ...behind]);
  let output = "";
  child.stdout.on("data", (data) => (output += data));
  await until(`server ${name}`, () => {
    if (child.exitCode !== null) throw new Error(`server ${name} ended: ${readFileSync(`${work}/${name}.log`, "utf8").slice(-2000)}`);
    return output.includes("ready:");
  });
  return child;
}
const behindProxy = ["--http-behind-proxy", "127.0.0.1", "--stations-behind-proxy", "127.0.0.1", "--host-name", "enamel.test", "--drain-seconds", "3"];
export const serveOne = (name) => serve(name, `${work}/${name}`, servers[name], behindProxy);
export async function startProxy() {
  // The file that is shipped, with a third server.
  const config = readFileSync(`${root}/server/ops/haproxy.cfg`, "utf8").replace(/^( *server) two (.*)\$\{ENAMEL_SERVER_TWO\}(.*)$/gm, "$&\n$1 three $2${ENAMEL_SERVER_THREE}$3");
  writeFileSync(`${work}/haproxy.cfg`, config);
  start("haproxy", "haproxy", ["-f", `${work}/haproxy.cfg`], {
    ENAMEL_PAGE_ADDRESS: `127.0.0.1:${proxy}`, ENAMEL_STATIONS_ADDRESS: `127.0.0.1:${proxy + 1}`, ENAMEL_PAGE_CERTIFICATE: `${work}/page.pem`,
    ENAMEL_HOST_NAME: "enamel.test", ENAMEL_SERVER_ONE: servers.one, ENAMEL_SERVER_TWO: servers.two, ENAMEL_SERVER_THREE: servers.three,
    ENAMEL_SERVER_PAGE_PORT: String(port), ENAMEL_SERVER_STATION_PORT: String(port + 1) });
  await until("HAProxy", () => new Promise((done) => net.connect(proxy + 1, "127.0.0.1").on("connect", function () { this.destroy(); done(true); }).on("error", () => done(false))));
}
// Every process of Swift.
export const swift = () => readdirSync("/proc").filter((pid) => /^\d+$/.test(pid)).filter((pid) => {
  try { return readFileSync(`/proc/${pid}/cmdline`, "utf8").includes("swift-") && readFileSync(`/proc/${pid}/stat`, "utf8").includes("(swift-"); } catch { return false; }
});

// Stations that stream: `enamel-loadgen` compares what the store has with what was sent.
export function load(name, data, address, { stations, minutes }, pids) {
  const file = `${work}/${name}.json`;
  const child = start(name, `${bin}/enamel-loadgen`, ["--server", address, "--data", data, "--stations", String(stations), "--minutes", String(minutes),
    "--loop-seconds", "2", "--json", file, ...pids.flatMap((pid) => ["--server-pid", String(pid)])]);
  let output = "";
  for (const stream of [child.stdout, child.stderr]) stream.on("data", (data) => (output += data));
  child.streams = until(`load ${name}`, () => { if (child.exitCode !== null) throw new Error(`load ${name} ended: ${output.slice(-2000)}`); return output.includes("streaming"); }, 600);
  child.facts = child.ended.then(() => {
    let found;
    try { found = jsonOf(file); } catch { throw new Error(`load ${name}: ${output.slice(-2000)}`); }
    running.delete(name);
    if (found.problem) say(`  ${name}: ${found.problem}`);
    addLost(found.ticks_lost + found.ticks_doubled + (found.ticks_sent - found.ticks_committed));
    return found;
  });
  return child;
}
// CPU seconds of processes and those that they have started.
const hertz = Number(execFileSync("getconf", ["CLK_TCK"], { encoding: "utf8" }));
export function cpuOf(roots) {
  const all = new Map();
  for (const name of readdirSync("/proc")) {
    if (!/^\d+$/.test(name)) continue;
    try {
      const fields = readFileSync(`/proc/${name}/stat`, "utf8").replace(/^.*\) /, "").split(" ");
      all.set(Number(name), { parent: Number(fields[1]), cpu: fields.slice(11, 15).reduce((sum, ticks) => sum + Number(ticks), 0) / hertz });
    } catch {}
  }
  const isOurs = (pid) => { for (; pid > 1; pid = all.get(pid)?.parent ?? 0) if (roots.includes(pid)) return true; return false; };
  return [...all].reduce((sum, [pid, { cpu }]) => sum + (isOurs(pid) ? cpu : 0), 0);
}
export const partsOf = () => ({ servers: Object.keys(servers).map((name) => running.get(name).pid), haproxy: [running.get("haproxy").pid],
  primary: [postmaster("one")], standby: [postmaster("two")], swift: swift().map(Number) });
export const clusterPids = () => [...Object.keys(servers).map((name) => running.get(name).pid), running.get("haproxy").pid, postmaster("one"), postmaster("two"), ...swift()];

// --- the parts of more than one file
// The school of `folder` on three servers behind HAProxy; gives where stations connect.
export async function moveToCluster(folder) {
  section("moved to three servers behind HAProxy, PostgreSQL with a synchronous standby, Swift");
  await enamel("move", "--data", folder, "--to", `${work}/one`, ...database("one"));
  for (const name of ["two", "three"]) await enamel("init", "--data", `${work}/${name}`, ...database(name), "--identity", `${work}/one`);
  for (const name of Object.keys(servers)) await serveOne(name);
  await startProxy();
  return `127.0.0.1:${proxy + 1}`;
}
export const timesSaid = (name, word) => readFileSync(`${work}/haproxy.log`, "utf8").split(`station_servers/${name} is ${word}`).length;
// As it has said last.
const isUp = (name) => (readFileSync(`${work}/haproxy.log`, "utf8").match(new RegExp(`(page|station)_servers/${name} is (UP|DOWN)`, "g")) ?? []).slice(-2).every((said) => said.endsWith("UP"));
export const untilAllUp = () => until("HAProxy sends to every server", () => Object.keys(servers).every(isUp));
export const untilSynchronous = () => until("a synchronous standby", async () => (await ask("SELECT count(*) FROM pg_stat_replication WHERE sync_state = 'sync'")) === "1");
// The standby takes over; gives the seconds that it took.
export async function promote() {
  const next = primary === "one" ? "two" : "one", began = now();
  await shell(`postgres pg_ctl -D ${pg}/${next} -w -t 60 promote`);
  primary = next;
  return now() - began;
}
// The primary that was follows the new one.
export async function rejoin() {
  const old = primary === "one" ? "two" : "one";
  await shell(`postgres_end ${pg}/${old}; rm -f ${pg}/${old}.socket/.s.*; postgres_standby ${pg} ${primary} ${old}`);
  // Not before: the copy would name itself, and wait for itself once it has taken over.
  await ask(`ALTER SYSTEM SET synchronous_standby_names = '${old}'`);
  await ask("SELECT pg_reload_conf()");
}
// A load that lasts for all of the faults, restarted where it would end too early.
export function streams({ stations, minutes, data, at }) {
  let stream, left = 0, count = 0;
  const found = { ticks_lost: 0, ticks_doubled: 0 };
  const end = async () => {
    if (!stream) return found;
    const facts = await stream.facts;
    stream = undefined;
    found.ticks_lost += facts.ticks_lost;
    found.ticks_doubled += facts.ticks_doubled;
    return found;
  };
  const ready = async () => {
    if (now() <= left) return;
    await end();
    stream = load(`stream-${count++}`, data, at, { stations, minutes }, []);
    await stream.streams;
    left = now() + minutes * 60 - 15;
    await until("all stations stream", async () => Number(await ask("SELECT count(*) FROM school.attempts WHERE state = 2 AND chunks > 0")) >= stations);
  };
  return { ready, end };
}
