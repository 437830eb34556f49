#!/usr/bin/env bash
# kill_bench.sh [KILLS [STATIONS]]: a server that STATIONS stations (3) stream to is killed (kill -9) KILLS times
# (3, or 20 with ENAMEL_FULL=1) at random moments, each time up to 1.5 s after it was ready again. Then every
# station's ticks are compared with the server's, and everything on the server with everything (verify).
# Prints how long each restart took: from starting the program to its "ready".  ENAMEL_SEED repeats the choices.
#   tests/faults/kill_bench.sh 200      five to ten minutes
. "$(dirname "$0")/../integration/support.sh"
kills=${1:-}
[ -n "$kills" ] || { [ "${ENAMEL_FULL:-}" = 1 ] && kills=20 || kills=3; }
stations=${2:-3}
seed=${ENAMEL_SEED:-$((SRANDOM % 100000))}
RANDOM=$seed
enamel_server=$bin/enamel-server enamel_station=$bin/enamel-station
data=$work/server
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-student1
echo "seed $seed: $kills kills, $stations stations"

now_ms() { date +%s%3N; }

# Starts the server and sets `took_ms`.
timed_start() {
  local begin
  : >"$work/server.log"
  begin=$(now_ms)
  "$enamel_server" serve --data "$data" --http "127.0.0.1:$port" --stations "127.0.0.1:$((port + 1))" >"$work/server.log" 2>&1 &
  server=$!
  pids+=("$server")
  until grep -q '^ready' "$work/server.log"; do
    kill -0 "$server" 2>/dev/null || { cat "$work/server.log"; fail "the server did not start"; }
    [ $(($(now_ms) - begin)) -lt 60000 ] || fail "the server was not ready within 60 s"
    sleep 0.01
  done
  took_ms=$(($(now_ms) - begin))
}

# One attempt after the other until the stop file is there; a broken link is the station's own business.
stream() {
  local i=$1 station=$work/station$1
  until [ -e "$work/stop" ]; do
    "$enamel_station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" \
      --user "chair$i" --operator student >>"$station.log" 2>&1 || sleep 0.2
  done
}

"$enamel_server" init --data "$data" >/dev/null
"$enamel_server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
add_students "$data" "$stations"
timed_start
for i in $(seq "$stations"); do
  code=$("$enamel_server" admin enrol-code --data "$data")
  "$enamel_station" enrol --data "$work/station$i" --server "127.0.0.1:$((port + 1))" --code "$code" --name "bench $i" >/dev/null
done
streams=()
for i in $(seq "$stations"); do
  stream "$i" &
  streams+=("$!")
  pids+=("$!")
done

committed() {
  "$enamel_server" admin list-attempts --data "$data" --limit 100000 | awk '{ for (i = 2; i <= NF; ++i) if ($i == "ticks") n += $(i - 1) } END { print n + 0 }'
}
restarts=()
sleep 3
for kill in $(seq "$kills"); do
  delay=$((RANDOM % 1500))
  sleep "$(printf '%d.%03d' $((delay / 1000)) $((delay % 1000)))"
  kill_server
  timed_start
  restarts+=("$took_ms")
  [ $((kill % 10)) -ne 0 ] || echo "  $kill kills, $(committed) ticks committed, last restart $took_ms ms"
done

touch "$work/stop"
for pid in "${streams[@]}"; do wait "$pid" || true; done
attempts=0 ticks=0
for i in $(seq "$stations"); do
  "$enamel_station" upload --data "$work/station$i" >"$work/upload.log" 2>&1 || { cat "$work/upload.log"; fail "station $i could not upload"; }
  "$enamel_server" admin list-attempts --data "$data" --limit 100000 >"$work/list"
  while read -r line; do
    id=${line%% *}
    recorded=$(awk '{ for (i = 2; i <= NF; ++i) if ($i == "ticks") { print $(i - 1); exit } }' <<<"$line")
    stored=$(awk -v id="$id" '$1 == id { for (i = 2; i <= NF; ++i) if ($i == "ticks") { print $(i - 1); exit } }' "$work/list")
    [ -n "$stored" ] || fail "attempt $id of station $i is not on the server"
    [ "$stored" = "$recorded" ] || fail "attempt $id: station $i recorded $recorded ticks, the server has $stored"
    attempts=$((attempts + 1)) ticks=$((ticks + recorded))
  done < <("$enamel_station" spool list --data "$work/station$i" | grep -E '^[0-9a-f-]{36} ')
done
"$enamel_server" verify --data "$data" >"$work/verify" 2>&1 || { cat "$work/verify"; fail "the server's data does not agree with itself"; }
stop_server
[ "$attempts" -gt 0 ] || fail "nothing was recorded"
printf '%s\n' "${restarts[@]}" | sort -n | awk -v kills="$kills" -v attempts="$attempts" -v ticks="$ticks" '
  { t[NR] = $1 }
  END { printf "%d kills: %d attempts, %d ticks, 0 lost, 0 doubled; restart median %d ms, longest %d ms (goal 2000 ms)\n",
               kills, attempts, ticks, t[int((NR + 1) / 2)], t[NR] }'
tail -n 1 "$work/verify"
