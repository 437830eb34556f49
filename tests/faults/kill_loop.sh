#!/usr/bin/env bash
# kill_loop.sh [ROUNDS]: server and station are killed (kill -9) at random moments of an attempt, and
# every tick that the station recorded is on the server once, replays to its witness and is scored.
#   ROUNDS: 3, or 20 with ENAMEL_FULL=1.  ENAMEL_SEED repeats a run's choices.
. "$(dirname "$0")/../integration/support.sh"
rounds=${1:-}
[ -n "$rounds" ] || { [ "${ENAMEL_FULL:-}" = 1 ] && rounds=20 || rounds=3; }
seed=${ENAMEL_SEED:-$((SRANDOM % 100000))}
RANDOM=$seed
echo "seed $seed, $rounds rounds (ENAMEL_SEED=$seed repeats the choices)"

server=""
port=$(free_ports)
data=$work/server station=$work/station
enamel_server=$bin/enamel-server enamel_station=$bin/enamel-station
export ENAMEL_PASSWORD=enamel-demo-student1

"$enamel_server" init --data "$data" >/dev/null
"$enamel_server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
code=$("$enamel_server" admin enrol-code --data "$data")
"$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$code" --name faults

# What the attempts are compared with, without any fault.
ENAMEL_PASSWORD=enamel-demo-instructor "$enamel_station" run --data "$station" --profile phantom_desktop --lockstep \
  --quiet --exercise "$exercise" --user instructor --operator dentist --as-reference --json "$work/cut.json" >/dev/null
reference=$(json_of "$work/cut.json" attempt_id)
"$enamel_server" report --data "$data" --attempt "$reference" --wait 600 >/dev/null
"$enamel_server" admin mark-reference --data "$data" --attempt "$reference" --dentist "Simulated dentist" --consent

start_attempt() {
  rm -f "$work/cut.json"
  "$enamel_station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" \
    --user student1 --operator student --json "$work/cut.json" >"$work/cut.log" 2>&1 &
  runner=$!
  pids+=("$runner")
}
broken=" "  # attempts that will never have an end
running() { kill -0 "$runner" 2>/dev/null; }

# wait_for recorded|committed N: until the attempt has N chunks, or is over.
wait_for() {
  local what=$1 n=$2 newest recorded committed
  while running; do
    sleep 0.02
    newest=$("$enamel_station" spool list --data "$station" 2>/dev/null | tail -n 1)
    [[ $newest == *unfinished* && $broken != *" ${newest%% *} "* ]] || continue
    read -r recorded committed < <(chunks_of "$station")
    [ "${!what}" -lt "$n" ] || return 0
  done
}

# ticks_of ATTEMPT: as `enamel-server admin list-attempts` has it.
ticks_of() {
  "$enamel_server" admin list-attempts --data "$data" |
    awk -v id="$1" '$1 == id { n = 0; for (i = 2; i <= NF; ++i) if ($i == "ticks") n = $(i - 1); print n }'
}

kill_server_during_attempt() {
  local kills=$((1 + RANDOM % 2)) what rc=0
  start_attempt
  for _ in $(seq "$kills"); do
    [ $((RANDOM % 2)) -eq 0 ] && what=recorded || what=committed
    local chunks=$((1 + RANDOM % 12))
    local delay=$((RANDOM % 300))
    wait_for "$what" "$chunks"
    sleep "$(printf '0.%03d' "$delay")"
    kill_server
    echo "  server killed $delay ms after $chunks chunks $what"
    [ $((RANDOM % 3)) -eq 0 ] || { start_server "$data" "$port"; }
    kill -0 "$server" 2>/dev/null || break
  done
  wait "$runner" || rc=$?
  [ $rc -eq 0 ] || [ $rc -eq 3 ] || { cat "$work/cut.log"; fail "the station ended with exit code $rc"; }
  kill -0 "$server" 2>/dev/null || start_server "$data" "$port"
  "$enamel_station" upload --data "$station" >"$work/upload.log" || { cat "$work/upload.log"; fail "upload"; }
}

# Now and then the server dies once more while it scores: the job is taken up again.
kill_server_during_scoring() {
  [ $((RANDOM % 2)) -eq 0 ] || return 0
  local delay=$((RANDOM % 800))
  sleep "$(printf '0.%03d' "$delay")"
  kill_server
  echo "  server killed while it may have been scoring"
  start_server "$data" "$port"
}

expect_all_on_server() {
  local attempt ticks stored
  attempt=$(json_of "$work/cut.json" attempt_id)
  ticks=$(json_of "$work/cut.json" ticks)
  stored=$(ticks_of "$attempt")
  [ "$stored" = "$ticks" ] || fail "the station recorded $ticks ticks of $attempt, the server has ${stored:-none}"
  kill_server_during_scoring
  "$enamel_server" report --data "$data" --attempt "$attempt" --wait 600 --json "$work/report.json" >"$work/report.log" 2>&1 ||
    { cat "$work/report.log" "$work/server.log"; fail "attempt $attempt was not scored"; }
  [ "$(json_of "$work/report.json" ticks)" = "$ticks" ] || fail "the score counts other ticks than the station recorded"
  [ "$(json_of "$work/report.json" witness_ok)" = true ] || fail "the replay of $attempt disagrees with what was recorded"
  echo "  all $ticks ticks arrived once, replayed and scored"
}

kill_station_during_attempt() {
  local chunks=$((1 + RANDOM % 15)) attempt recorded line
  start_attempt
  wait_for recorded "$chunks"
  running || fail "the attempt was over before the station could be killed"
  kill -KILL "$runner"
  wait "$runner" 2>/dev/null || true
  line=$("$enamel_station" spool list --data "$station" | tail -n 1)
  [[ $line == *unfinished* ]] || fail "the broken-off attempt is not listed as unfinished: $line"
  attempt=${line%% *}
  recorded=$(awk '{ for (i = 2; i <= NF; ++i) if ($i == "ticks") print $(i - 1) }' <<<"$line")
  [ "$recorded" -ge $((chunks * 500)) ] || fail "$chunks chunks were on disk, now there are $recorded ticks"
  "$enamel_station" spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "the spool is damaged"; }
  grep -q "^$attempt  whole" "$work/verify" || { cat "$work/verify"; fail "what was spooled of $attempt is not whole"; }
  "$enamel_station" upload --data "$station" >"$work/upload.log" || { cat "$work/upload.log"; fail "upload"; }
  [ "$(ticks_of "$attempt")" = "$recorded" ] || fail "of $recorded spooled ticks $(ticks_of "$attempt") arrived"
  "$enamel_station" upload --data "$station" | grep -q "nothing to upload" || fail "a second upload had something left to send"
  broken+="$attempt "
  echo "  station killed: all $recorded spooled ticks are whole and arrived"
}

for round in $(seq "$rounds"); do
  echo "round $round"
  kill_server_during_attempt
  expect_all_on_server
  kill_station_during_attempt
done

# Stopping in order is no fault of the job: however often, it costs none of its tries.
start_attempt
wait "$runner" || { cat "$work/cut.log"; fail "an attempt without faults"; }
cut_short=0
for _ in 1 2 3 4; do
  stop_server
  if grep -q 'the job runs again after the next start' "$work/server.log"; then cut_short=$((cut_short + 1)); fi
  start_server "$data" "$port"
done
"$enamel_server" report --data "$data" --attempt "$(json_of "$work/cut.json" attempt_id)" --wait 600 >"$work/report.log" 2>&1 ||
  { cat "$work/report.log"; fail "an attempt whose scoring was interrupted in order four times was not scored"; }
echo "scored after four orderly stops, $cut_short of them while scoring"

"$enamel_station" spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "the spool is damaged"; }
[ "$(grep -c '  whole$' "$work/verify")" -eq $((2 * rounds + 2)) ] || { cat "$work/verify"; fail "expected $((2 * rounds + 2)) attempts"; }
stop_server
echo "nothing lost in $rounds rounds"
