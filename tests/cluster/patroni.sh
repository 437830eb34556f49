#!/usr/bin/env bash
# PostgreSQL under Patroni and etcd, as server/ops/patroni.yml has it, with a server that knows both members. While a station
# uploads, the primary's machine dies (Patroni and PostgreSQL at once): the standby takes over by itself, not a tick is
# lost or doubled, and the old primary comes back as a standby.
. "$(dirname "$0")/../integration/support.sh"
. "$root/tests/support/postgres_server.sh"
[ -n "${ENAMEL_FULL:-}" ] || { echo "skipped: it waits for a minute; ENAMEL_FULL=1 runs it"; exit 77; }
for program in patroni etcd curl; do
  command -v $program >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
pg=$work/pg
mkdir "$pg"
chmod 711 "$work"
postgres_user "$pg"
member_pids=()
end() {
  local pid
  for pid in "${member_pids[@]:-}"; do [ -z "$pid" ] || kill -KILL -- "-$pid" 2>/dev/null || true; done
  for data in "$pg"/*.data; do
    [ ! -f "$data/postmaster.pid" ] || kill -QUIT "$(head -1 "$data/postmaster.pid")" 2>/dev/null || true
  done
  stop_all
}
trap end EXIT

etcd_port=$(free_ports)
cp "$root/server/ops/patroni.yml" "$pg/patroni.yml"
chmod 644 "$pg/patroni.yml"
cat >"$pg/environment" <<END
PATRONI_ETCD3_HOSTS=127.0.0.1:$etcd_port
PATRONI_SUPERUSER_PASSWORD=of-the-superuser
PATRONI_REPLICATION_PASSWORD=of-the-replicator
END
# In a session of its own each, so that all of a member can be killed at once.
(cd "$pg" && exec setsid "${postgres_as[@]}" etcd --name e --data-dir "$pg/etcd" --listen-client-urls "http://127.0.0.1:$etcd_port" \
  --advertise-client-urls "http://127.0.0.1:$etcd_port" --listen-peer-urls "http://127.0.0.1:$((etcd_port + 1))" \
  --initial-advertise-peer-urls "http://127.0.0.1:$((etcd_port + 1))" --initial-cluster "e=http://127.0.0.1:$((etcd_port + 1))" \
  --unsafe-no-fsync >"$work/etcd.log" 2>&1) &
member_pids+=("$!")
declare -A port_of pid_of
# begin NAME
begin() {
  local name=$1 port=${port_of[$1]}
  (cd "$pg" && exec setsid "${postgres_as[@]}" env -u PGPASSWORD $(cat "$pg/environment") PATRONI_NAME="$name" \
    PATRONI_RESTAPI_LISTEN="127.0.0.1:$((port + 1))" PATRONI_RESTAPI_CONNECT_ADDRESS="127.0.0.1:$((port + 1))" \
    PATRONI_POSTGRESQL_LISTEN="127.0.0.1:$port" PATRONI_POSTGRESQL_CONNECT_ADDRESS="127.0.0.1:$port" \
    PATRONI_POSTGRESQL_DATA_DIR="$pg/$name.data" PATRONI_POSTGRESQL_BIN_DIR="$postgres_programs" PATRONI_POSTGRESQL_PGPASS="$pg/$name.pgpass" \
    patroni "$pg/patroni.yml" >>"$work/patroni-$name.log" 2>&1) &
  pid_of[$name]=$!
  member_pids+=("$!")
}
# until_is NAME ROLE: as Patroni's own interface says, at most two minutes.
until_is() {
  local deadline=$((SECONDS + 120))
  until [ "$(curl -s -o /dev/null -w '%{http_code}' "http://127.0.0.1:$((port_of[$1] + 1))/$2")" = 200 ]; do
    [ $SECONDS -lt $deadline ] || { tail -n 30 "$work"/patroni-*.log "$work/etcd.log"; fail "$1 was not $2 within two minutes"; }
    sleep 0.2
  done
}
port_of[one]=$(free_ports)
begin one
until_is one primary
port_of[two]=$(free_ports)
begin two
until_is two sync
export PGPASSWORD=of-the-superuser
# ask NAME SQL
ask() { psql -X -A -t -d "host=127.0.0.1 port=${port_of[$1]} user=postgres dbname=${3:-enamel}" -c "$2"; }
ask one "CREATE DATABASE enamel" postgres >/dev/null

data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor
both="host=127.0.0.1,127.0.0.1 port=${port_of[one]},${port_of[two]} user=postgres dbname=enamel"
"$bin/enamel-server" init --data "$data" --database "$both" --schema school >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 150 --json "$work/seed" >/dev/null
start_server "$data" "$port"
wait_for_log "$work/server.log" 'commits are on a standby of the database server too'
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" --name patroni >/dev/null
"$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$(json_of "$work/seed" exercise)" \
  --user instructor --operator dentist --as-reference --uplink-kbit 200 --json "$work/cut.json" >"$work/run.log" 2>&1 &
cutting=$!
pids+=("$cutting")
chunks() { ask "$1" "SELECT coalesce(max(chunks), 0) FROM school.attempts" 2>/dev/null || echo 0; }
# until_more_than NAME COUNT
until_more_than() {
  local deadline=$((SECONDS + 120))
  until [ "$(chunks "$1")" -gt "$2" ]; do
    [ $SECONDS -lt $deadline ] || { tail -n 20 "$work"/*.log; fail "nothing came in for 120 s"; }
    sleep 0.1
  done
}
until_more_than one 1
kill -0 "$cutting" || { cat "$work/run.log"; fail "the attempt ended before the primary was killed"; }
kill -KILL -- "-${pid_of[one]}"
kill -KILL "$(head -1 "$pg/one.data/postmaster.pid")"
killed=$(date +%s%N)
# Signing in is written: it goes through once the server has found the new primary.
deadline=$((SECONDS + 120))
until [ "$(curl -s -o "$work/answer" -w '%{http_code}' -H 'Content-Type: application/json' "http://127.0.0.1:$port/api/v1/session" \
  -d '{"login": "student1", "password": "enamel-demo-student1"}')" = 200 ]; do
  [ $SECONDS -lt $deadline ] || { tail -n 30 "$work"/*.log; fail "nobody could sign in for 120 s: $(cat "$work/answer")"; }
  sleep 0.2
done
echo "ok: $(($(date +%s%N) / 1000000 - killed / 1000000)) ms from the primary's end until the server writes to the standby"
ended=0
wait "$cutting" || ended=$?
# It waits some seconds for its server and then keeps the rest for later: exit 3, and nothing is lost.
[ $ended != 3 ] || { ended=0; "$bin/enamel-station" upload --data "$station" >/dev/null || ended=$?; }
[ $ended = 0 ] || { cat "$work/run.log"; fail "the station ended with $ended"; }
id=$(json_of "$work/cut.json" attempt_id)
"$bin/enamel-server" report --data "$data" --attempt "$id" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" ticks)" = "$(json_of "$work/cut.json" ticks)" ] ||
  fail "expected $(json_of "$work/cut.json" ticks) ticks, found $(json_of "$work/report.json" ticks)"
[ "$(ask two "SELECT count(*) FROM school.attempts")" = 1 ] || fail "expected one attempt"
echo "ok: $(json_of "$work/cut.json" ticks) ticks past a primary that died, none lost or doubled"
begin one
until_is one sync
echo "ok: the old primary is a synchronous standby again"
stop_server
