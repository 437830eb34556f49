#!/usr/bin/env bash
# station_kill_bench.sh [KILLS]: a station is killed (kill -9) KILLS times (5, or 20 with ENAMEL_FULL=1) at random moments
# of its attempts, up to as long as a whole one takes, and started again each time: an attempt that was cut off is resumed.
# After each kill everything that the spool had listed before is there; in the end every recording is whole (chain,
# signatures, seals), every resumed one has a declared gap, the server has every tick once, and what it has replays.
#   tests/faults/station_kill_bench.sh 1000      what the issue asks for; about half an hour.  ENAMEL_SEED repeats the choices.
. "$(dirname "$0")/../integration/support.sh"
kills=${1:-}
[ -n "$kills" ] || { [ "${ENAMEL_FULL:-}" = 1 ] && kills=20 || kills=5; }
seed=${ENAMEL_SEED:-$((SRANDOM % 100000))}
RANDOM=$seed
enamel_server=$bin/enamel-server enamel_station=$bin/enamel-station
data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-student1
echo "seed $seed: $kills kills"

"$enamel_server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port" --job-threads 0
"$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$("$enamel_server" admin enrol-code --data "$data")" --name bench >/dev/null

# Newest attempt: sets id, state, ticks; empty id: none.
look() {
  local line
  line=$("$enamel_station" spool list --data "$station" | tail -n 1)
  read -r id state _ <<<"$line"
  [[ $id == *-*-* ]] || id=""
  ticks=$(awk '{ for (i = 2; i <= NF; ++i) if ($i == "ticks") { print $(i - 1); exit } }' <<<"$line")
}
# ticks_of ID: what the spool has of it now.
ticks_of() { "$enamel_station" spool list --data "$station" | awk -v id="$1" '$1 == id { for (i = 2; i <= NF; ++i) if ($i == "ticks") print $(i - 1) }'; }
random_s() { awk -v r="$((RANDOM * 32768 + RANDOM))" -v ms="$1" 'BEGIN { printf "%.3f", r / 1073741824 * ms / 1000 }'; }
now_ms() { date +%s%3N; }

# One attempt without a kill: how long one takes here.
begin=$(now_ms)
"$enamel_station" run --data "$station" --lockstep --quiet --user student1 --operator student --exercise "$exercise" \
  --profile phantom_desktop >/dev/null
whole_ms=$(($(now_ms) - begin))
echo "a whole attempt takes $whole_ms ms"

resumes=0 finished=0 early=0
look
for kill in $(seq "$kills"); do
  how=(--exercise "$exercise" --profile phantom_desktop)
  if [ "$state" = unfinished ]; then
    how=(--resume last)
    resumes=$((resumes + 1))
  fi
  "$enamel_station" run --data "$station" --lockstep --quiet --user student1 --operator student "${how[@]}" >"$work/run.log" 2>&1 &
  runner=$!
  pids+=("$runner")
  sleep "$(random_s "$whole_ms")"
  look
  seen=$id seen_ticks=${ticks:-0}
  sleep "$(random_s 200)"
  if kill -KILL "$runner" 2>/dev/null; then early=$((early + 1)); else finished=$((finished + 1)); fi
  rc=0
  wait "$runner" 2>/dev/null || rc=$?
  pids=("${pids[0]}")
  [ $rc -eq 0 ] || [ $rc -eq 137 ] || { cat "$work/run.log"; fail "kill $kill: the station ended with exit code $rc"; }
  look
  [ -z "$seen" ] || [ "$(ticks_of "$seen")" -ge "$seen_ticks" ] || fail "kill $kill: $seen had $seen_ticks ticks in the spool, now $(ticks_of "$seen")"
  [ $((kill % 25)) -ne 0 ] || {
    "$enamel_station" spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "kill $kill: the spool is damaged"; }
    echo "  $kill kills, $resumes resumed, $(wc -l <"$work/verify") attempts, all whole"
  }
done
[ "$state" != unfinished ] || "$enamel_station" spool close last --data "$station" >/dev/null
"$enamel_station" spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "the spool is damaged"; }
"$enamel_station" upload --data "$station" >"$work/upload" || { cat "$work/upload"; fail "upload"; }
"$enamel_station" spool list --json --data "$station" >"$work/spool.json"
"$enamel_server" admin list-attempts --data "$data" --limit 100000 >"$work/list"
node -e '
  const fs = require("fs"), [, spool, list, kills, resumes] = process.argv;
  const server = new Map(fs.readFileSync(list, "utf8").split("\n").map((l) => [l.split(" ")[0], +(l.match(/(\d+) ticks/) ?? [0, -1])[1]]));
  const die = (why) => { console.error("FAILED: " + why); process.exit(1); };
  let ticks = 0, gaps = 0, resumed = 0;
  const attempts = JSON.parse(fs.readFileSync(spool, "utf8")).attempts.filter((a) => a.chunks > 0);
  for (const a of attempts) {
    if (a.state !== "uploaded") die(`attempt ${a.attempt_id} is ${a.state}`);
    if (server.get(a.attempt_id) !== a.ticks) die(`attempt ${a.attempt_id}: ${a.ticks} ticks here, ${server.get(a.attempt_id)} at the server`);
    if (a.resumed > 0 && a.gap_ticks === 0) die(`attempt ${a.attempt_id} was resumed ${a.resumed} times without a declared gap`);
    ticks += a.ticks; gaps += a.gap_ticks; resumed += a.resumed;
  }
  console.log(`${kills} kills: ${attempts.length} attempts, ${ticks} ticks, 0 lost, 0 doubled; ${resumed} times taken up again, gaps declared ${gaps} ticks`);
' "$work/spool.json" "$work/list" "$early" "$resumes"
# What was resumed most often re-runs to its witness.
most=$(node -p 'JSON.parse(require("fs").readFileSync(process.argv[1], "utf8")).attempts.filter((a) => a.chunks > 0).sort((a, b) => b.resumed - a.resumed)[0].attempt_id' "$work/spool.json")
"$enamel_station" spool export --data "$station" "$most" --out "$work/most.trace" >/dev/null
"$enamel_station" replay --data "$station" "$work/most.trace" --no-keyframes | tail -n 3
"$enamel_server" verify --data "$data" | tail -n 1
stop_server
echo "$finished attempts were over before their kill"
