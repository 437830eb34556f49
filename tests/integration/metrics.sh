#!/usr/bin/env bash
# What an operator watches: every figure that server/ops/grafana_dashboard.json and prometheus_rules.yml name is one that a
# server has, and the logs tell of one request, and of one recording, by its id. Prometheus' own promtool looks at its files where it is installed.
. "$(dirname "$0")/support.sh"
data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 150 --json "$work/seed" >/dev/null
"$bin/enamel-server" backup "$work/backup" --data "$data" >/dev/null
start_server "$data" "$port" --log-format json --log-level debug --job-threads 0
ENAMEL_LOG_FORMAT=json "$bin/enamel-server" work --data "$data" >"$work/worker.log" 2>&1 &
pids+=($!)
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name watched \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" >/dev/null
"$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$(json_of "$work/seed" exercise)" \
  --user instructor --operator dentist --as-reference --json "$work/cut" >/dev/null
"$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/cut" attempt_id)" --wait 600 >/dev/null

cat >"$work/look.mjs" <<'JS'
import {readFileSync} from "node:fs";
const [ops, page, log, workerLog, attempt] = process.argv.slice(2);
const fail = (what) => { console.error(`FAILED: ${what}`); process.exit(1); };
const text = await (await fetch(`${page}/metrics`)).text();
const values = new Map();
for (const line of text.split("\n")) {
  const found = /^([a-z0-9_]+)(?:\{.*\})? ([-+.e0-9]+)$/.exec(line);
  if (found) values.set(found[1], Number(found[2]));
}
// Of a database that has standbys, and of stores in buckets (tests/cluster/school_in_s3.sh).
const elsewhere = new Set(["enamel_database_synchronous_standby", "enamel_database_standby_missing",
  "enamel_s3_failed_calls_total", "enamel_s3_oldest_wait_seconds"]);
let named = 0;
const look = (where, expression) => {
  for (const [name] of expression.matchAll(/\b(?:enamel|process)_[a-z0-9_]+/g)) {
    ++named;
    if (!values.has(name) && !elsewhere.has(name)) fail(`${where}: ${name} is no figure of a server`);
  }
};
const dashboard = JSON.parse(readFileSync(`${ops}/grafana_dashboard.json`, "utf8"));
for (const panel of dashboard.panels) for (const target of panel.targets) look(panel.title, target.expr);
const rules = readFileSync(`${ops}/prometheus_rules.yml`, "utf8");
for (const [, expression] of rules.matchAll(/^ *expr: (.*)$/gm)) look("rules", expression);
if (named < 20) fail(`only ${named} figures are named: were the files read?`);
if (!(values.get("enamel_ingest_lag_seconds_count") > 0)) fail("no chunk was counted");
if (!(values.get("enamel_store_commit_seconds_count") > 0)) fail("no commit was timed");
console.log(`ok: ${named} figures of dashboard and rules are there`);

await fetch(`${page}/api/v1/attempts/${attempt}/score`);
const answer = await fetch(`${page}/api/v1/session`, {headers: {"X-Request-Id": "mine"}});
const id = answer.headers.get("x-request-id");
if (!/^[0-9a-f]{12}$/.test(id)) fail(`expected a request's id, found ${id}`);
const linesOf = (file) => readFileSync(file, "utf8").split("\n").filter((line) => line.startsWith("{")).map((line) => JSON.parse(line));
const lines = linesOf(log);
const told = lines.filter((line) => line.request === id);
if (told.length !== 1 || !/^http: GET \/api\/v1\/session: 401 after/.test(told[0].message)) fail(`of request ${id} the log says ${JSON.stringify(told)}`);
console.log(`ok: "${told[0].message}" of request ${id}`);

// One id tells a recording's story, whoever logs it.
const story = [...lines, ...linesOf(workerLog)].filter((line) => line.attempt === attempt).map(({message}) => message);
for (const part of [/sends a recording from chunk 0 on/, /^chunk 0 is stored/, /^the recording is whole/, /^job score of .* done$/, /^http: GET .*: 401/]) {
  if (!story.some((message) => part.test(message))) fail(`the story of ${attempt} lacks ${part}:\n${story.join("\n")}`);
}
console.log(`ok: ${story.length} lines of server and worker tell of attempt ${attempt}`);
JS
node "$work/look.mjs" "$root/server/ops" "http://127.0.0.1:$port" "$work/server.log" "$work/worker.log" "$(json_of "$work/cut" attempt_id)"
if command -v promtool >/dev/null; then
  promtool check config "$root/server/ops/prometheus.yml" >"$work/out" 2>&1 || { cat "$work/out"; fail "Prometheus would not take its settings"; }
  echo "ok: Prometheus takes its settings"
else
  echo "skipped: promtool is not installed, so nobody looked at the settings of Prometheus"
fi
stop_server
