#!/usr/bin/env bash
# PostgreSQL hangs: its processes are stopped, and its connections stay open. Within 5 s /readyz says 503 and the log says
# why; /livez and /metrics answer. The standby takes over: the recording under way goes on, and not a tick is lost or
# doubled. The old primary wakes up, and nothing moves back. While the new one hangs the server ends within 10 s.
. "$(dirname "$0")/../integration/support.sh"
. "$root/tests/support/postgres_server.sh"
. "$root/tests/support/slow_cut.sh"
command -v curl >/dev/null || { echo "skipped: curl is not installed"; exit 77; }
pg=$work/pg
mkdir "$pg"
chmod 711 "$work"
postgres_user "$pg"
# signal_all NAME SIGNAL: each process of one of the two
signal_all() {
  local postmaster
  postmaster=$(head -1 "$pg/$1/postmaster.pid")
  # New processes are made by the first alone.
  kill "-$2" "$postmaster"
  pkill "-$2" -P "$postmaster" || true
}
end() {
  local name
  for name in one two; do
    [ ! -f "$pg/$name/postmaster.pid" ] || signal_all $name CONT 2>/dev/null || true
    postgres_end "$pg/$name"
  done
  stop_all
}
trap end EXIT
ask() { postgres_ask "$pg/$1.socket" "${@:2}"; }
postgres_pair "$pg"

data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor
"$bin/enamel-server" init --data "$data" --database "host=$pg/one.socket,$pg/two.socket user=enamel dbname=enamel" --schema school >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 150 --json "$work/seed" >/dev/null
start_server "$data" "$port"
now_ms() { echo $(($(date +%s%N) / 1000000)); }
# status PATH: of an answer within a second
status() { curl -s -m 1 -o "$work/answer" -w '%{http_code}' "http://127.0.0.1:$port$1" || true; }
# until_ready STATUS SINCE MOST: prints the milliseconds since
until_ready() {
  until [ "$(status /readyz)" = "$1" ]; do
    [ $(($(now_ms) - $2)) -lt "$3" ] || fail "/readyz is not $1 after $3 ms: $(cat "$work/answer"; tail -n 5 "$work/server.log")"
    sleep 0.05
  done
  echo $(($(now_ms) - $2))
}
[ "$(status /readyz)" = 200 ] || fail "not ready: $(cat "$work/answer")"
start_slow_cut hangs
chunks() { ask "$1" "SELECT coalesce(max(chunks), 0) FROM school.attempts"; }
until_more_than one 1

signal_all one STOP
hung=$(now_ms)
took=$(until_ready 503 "$hung" $((5000 * patience)))
grep -q 'database server does not answer' "$work/answer" || fail "/readyz gives no reason: $(cat "$work/answer")"
[ "$(status /livez)" = 200 ] || fail "/livez waits for the database"
[ "$(status /metrics)" = 200 ] || fail "/metrics waits for the database"
grep -q '^enamel_takes_recordings 0' "$work/answer" || fail "/metrics does not say that no recordings are taken"
wait_for_log "$work/server.log" 'no recordings are taken: the database server does not answer'
echo "ok: not ready $took ms after the primary hung; said in the log after $(($(now_ms) - hung)) ms"

promoted=$(now_ms)
postgres pg_ctl -D "$pg/two" -w -t 60 promote >/dev/null
echo "ok: PostgreSQL's own promotion took $(($(now_ms) - promoted)) ms"
promoted=$(now_ms)
before=$(chunks two)
until_more_than two "$before"
echo "ok: recordings are taken $(($(now_ms) - promoted)) ms after the promotion"
echo "ok: ready $(until_ready 200 "$promoted" $((20000 * patience))) ms after it"
signal_all one CONT
wait "$cutting" || { cat "$work/run.log"; fail "the station ended with an error"; }
[ "$(status /readyz)" = 200 ] || fail "not ready: $(cat "$work/answer")"
# As who promotes does: what connects from here on would take it for the primary.
postgres_end "$pg/one"
# The same words come once a minute, however often somebody asks.
said=$(sed -n 's/.*\[warning\] database: //p' "$work/server.log")
[ "$(sort <<<"$said" | uniq -c | sort -rn | awk 'NR == 1 {print $1}')" -le 3 ] || fail "the log repeats itself: $(sort <<<"$said" | uniq -c | sort -rn | head -3)"
echo "ok: $(wc -l <<<"$said") lines of the log on the database"
id=$(json_of "$work/cut.json" attempt_id)
"$bin/enamel-server" report --data "$data" --attempt "$id" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" ticks)" = "$(json_of "$work/cut.json" ticks)" ] || fail "expected $(json_of "$work/cut.json" ticks) ticks, found $(json_of "$work/report.json" ticks)"
[ "$(ask two "SELECT count(*) FROM school.attempts WHERE sealed_ms > 0")" = 1 ] || fail "expected one attempt on the new primary"
[ "$(status /readyz)" = 200 ] || fail "not ready: $(cat "$work/answer")"
echo "ok: $(json_of "$work/cut.json" ticks) ticks past a primary that hung, none lost or doubled"

signal_all two STOP
stopped=$(now_ms)
# A change that waits.
curl -s -m 20 -o /dev/null -H 'Content-Type: application/json' -d '{"login": "instructor", "password": "enamel-demo-instructor"}' "http://127.0.0.1:$port/api/v1/session" &
kill -TERM "$server"
wait "$server" || true
took=$(($(now_ms) - stopped))
[ $took -lt $((10000 * patience)) ] || fail "the server ended after $took ms"
echo "ok: the server ended $took ms after it was asked to, while the database hung"
