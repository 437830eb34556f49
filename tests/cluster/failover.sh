#!/usr/bin/env bash
# PostgreSQL with a synchronous standby, and a server that knows both. While a station uploads, the primary is killed and
# the standby takes over: not a tick is lost or doubled, the recording is scored, and health says what is left.
. "$(dirname "$0")/../integration/support.sh"
. "$root/tests/support/postgres_server.sh"
. "$root/tests/support/slow_cut.sh"
command -v curl >/dev/null || { echo "skipped: curl is not installed"; exit 77; }
pg=$work/pg
mkdir "$pg"
chmod 711 "$work"
postgres_user "$pg"
end() {
  postgres_end "$pg/one"
  postgres_end "$pg/two"
  stop_all
}
trap end EXIT
# ask SERVER SQL [DATABASE [USER]]
ask() { postgres_ask "$pg/$1.socket" "${@:2}"; }
postgres_pair "$pg"
ask one "CREATE ROLE plain LOGIN" >/dev/null
# Why the server's user is to be a member of pg_monitor.
[ "$(ask one "SELECT count(*), count(sync_state) FROM pg_stat_replication" enamel plain)" = "1|0" ] || fail "anybody may see a standby's state"

data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor
both="host=$pg/one.socket,$pg/two.socket user=enamel dbname=enamel"
"$bin/enamel-server" init --data "$data" --database "$both" --schema school >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 150 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
standby() { curl -s "http://127.0.0.1:$port/metrics" | sed -n 's/^enamel_database_synchronous_standby //p'; }
standby_missing() { curl -s "http://127.0.0.1:$port/metrics" | sed -n 's/^enamel_database_standby_missing //p'; }
wait_for_log "$work/server.log" 'commits are on a standby of the database server too'
[ "$(standby)" = 1 ] || fail "the figures do not tell of the standby"
start_slow_cut failover
chunks() { ask "$1" "SELECT coalesce(max(chunks), 0) FROM school.attempts WHERE sealed_ms = 0"; }
until_more_than one 1
kill -KILL "$(head -1 "$pg/one/postmaster.pid")"
killed=$(date +%s%N)
postgres pg_ctl -D "$pg/two" -w -t 60 promote >/dev/null
before=$(chunks two)
until_more_than two "$before"
echo "ok: $(($(date +%s%N) / 1000000 - killed / 1000000)) ms from the primary's end to the next chunk on the standby"
wait "$cutting" || { cat "$work/run.log"; fail "the station ended with an error"; }
id=$(json_of "$work/cut.json" attempt_id)
"$bin/enamel-server" report --data "$data" --attempt "$id" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" ticks)" = "$(json_of "$work/cut.json" ticks)" ] || fail "expected $(json_of "$work/cut.json" ticks) ticks, found $(json_of "$work/report.json" ticks)"
[ "$(ask two "SELECT count(*) FROM school.attempts")" = 1 ] || fail "expected one attempt"
[ "$(ask two "SELECT count(*) FROM school.attempt_results")" = 1 ] || fail "expected one result"
echo "ok: $(json_of "$work/cut.json" ticks) ticks past a primary that was killed, none lost or doubled"
wait_for_log "$work/server.log" 'no standby of the database server is synchronous any more'
[ "$(standby)" = 0 ] || fail "the figures do not tell that the standby is gone"
echo "ok: health says that nothing is kept twice any more"

# A standby that is to be waited for and is not there holds up every change, and the log says so. It comes, and all goes on.
ask two "ALTER SYSTEM SET synchronous_standby_names = 'one'" >/dev/null
ask two "SELECT pg_reload_conf()" >/dev/null
wait_for_log "$work/server.log" 'every change waits'
[ "$(curl -s "http://127.0.0.1:$port/readyz" | grep -c 'waits for a synchronous standby')" = 1 ] || fail "health does not say that changes wait"
[ "$(standby_missing)" = 1 ] || fail "the figures do not tell that changes wait"
began=$(ask two "SELECT clock_timestamp()")
"$bin/enamel-server" admin enrol-code --data "$data" >"$work/code" 2>&1 &
code=$!
pids+=("$code")
deadline=$((SECONDS + 60))
# Its connection, not the server's.
until [ "$(ask two "SELECT count(*) FROM pg_stat_activity WHERE wait_event = 'SyncRep' AND backend_start > '$began'")" -gt 0 ]; do
  [ $SECONDS -lt $deadline ] || fail "nobody waits for the standby"
  kill -0 "$code" 2>/dev/null || fail "a change was kept without a standby"
  sleep 0.2
done
kill -0 "$code" 2>/dev/null || fail "a change was kept without a standby"
rm -f "$pg"/one.socket/.s.*
postgres_standby "$pg" two one
wait "$code" || { cat "$work/code"; fail "a change that had waited for the standby failed"; }
until [ "$(grep -c 'commits are on a standby of the database server too' "$work/server.log")" -ge 2 ]; do
  [ $SECONDS -lt $((deadline + 60)) ] || fail "the log does not say that the standby is there"
  sleep 0.2
done
[ "$(standby_missing)" = 0 ] || fail "the figures still tell that changes wait"
echo "ok: changes wait for a standby that is missing, and go on when it is there"
