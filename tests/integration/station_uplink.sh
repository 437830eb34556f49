#!/usr/bin/env bash
# A station that is killed in the middle of an attempt goes on where its recording ends, or ends it there; a server
# restored from an older backup gets back what it lost; an attempt is made without the server on a ticket taken before; a
# cable that is pulled again and again loses nothing; nor does an interrupt while the rest is sent; who watches sees the
# attempt move.
. "$(dirname "$0")/support.sh"
data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-student1
server_cli() { "$bin/enamel-server" "$@"; }
station_cli() { "$bin/enamel-station" "$@"; }

server_cli init --data "$data" >/dev/null
server_cli seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
station_cli enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$(server_cli admin enrol-code --data "$data")" --name uplink
ENAMEL_PASSWORD=enamel-demo-instructor station_cli run --data "$station" --profile phantom_desktop --lockstep --quiet \
  --exercise "$exercise" --user instructor --operator dentist --as-reference --json "$work/cut.json" >/dev/null
reference=$(json_of "$work/cut.json" attempt_id)
server_cli report --data "$data" --attempt "$reference" --wait 600 >/dev/null
server_cli admin mark-reference --data "$data" --attempt "$reference" --dentist "Simulated dentist" --consent >/dev/null

# spool_of ATTEMPT MEMBER
spool_of() {
  station_cli spool list --json "$work/spool.json" --data "$station" >/dev/null
  node -e 'const a = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8")).attempts.find((a) => a.attempt_id === process.argv[2]);
           if (!a) process.exit(1); console.log(a[process.argv[3]]);' "$work/spool.json" "$1" "$2"
}
ticks_on_server() {
  server_cli admin list-attempts --data "$data" |
    awk -v id="$1" '$1 == id { n = 0; for (i = 2; i <= NF; ++i) if ($i == "ticks") n = $(i - 1); print n }'
}
cut_off_after() {
  cut_off "$station" "$1" "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet \
    --exercise "$exercise" --user student1 --operator student
}

echo "== resumed after kill -9"
cut_off_after 40
spooled=$(spool_of "$attempt" ticks)
[ "$(spool_of "$attempt" state)" = unfinished ] || fail "an attempt that was cut off is $(spool_of "$attempt" state)"
ENAMEL_PASSWORD=enamel-demo-student2 expect_failure "somebody else's attempt" "somebody else's" \
  "$bin/enamel-station" run --data "$station" --lockstep --quiet --user student2 --resume last
sleep 1
away_ms=$(($(date +%s%3N) - killed_ms))
station_cli run --data "$station" --lockstep --quiet --user student1 --operator student --resume last --json "$work/resumed.json"
back_ms=$(($(date +%s%3N) - killed_ms))
[ "$(json_of "$work/resumed.json" attempt_id)" = "$attempt" ] || fail "another attempt was resumed"
ticks=$(json_of "$work/resumed.json" ticks)
[ "$ticks" -gt "$spooled" ] || fail "$spooled ticks before, $ticks after it was resumed"
# A tick is a millisecond: the gap is the time from the last chunk before the kill (some seconds before, on a
# busy machine) to the first tick after it.
gap=$(json_of "$work/resumed.json" gap_ticks)
[ "$gap" -ge "$away_ms" ] && [ "$gap" -le "$((back_ms + 10000))" ] ||
  fail "away for $away_ms to $back_ms ms, declared gap $gap ticks"
[ "$(json_of "$work/resumed.json" resumed)" = 1 ] || fail "it does not count as resumed"
server_cli report --data "$data" --attempt "$attempt" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" witness_ok)" = true ] || fail "the resumed attempt does not replay at the server"
[ "$(json_of "$work/report.json" ticks)" = "$ticks" ] || fail "the server scored other ticks than were recorded"
echo "ok: $spooled ticks before the kill, $ticks in the end, replayed and scored"
expect_failure "resumed twice" "nothing to resume" "$bin/enamel-station" run --data "$station" --lockstep --quiet --user student1 --resume last

echo "== closed after kill -9"
cut_off_after 30
spooled=$(spool_of "$attempt" ticks)
station_cli spool close last --data "$station"
station_cli upload --data "$station" >/dev/null
server_cli report --data "$data" --attempt "$attempt" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" ticks)" = "$spooled" ] || fail "of $spooled ticks $(json_of "$work/report.json" ticks) were scored"
[ "$(spool_of "$attempt" state)" = uploaded ] || fail "the closed attempt is $(spool_of "$attempt" state)"
echo "ok: all $spooled spooled ticks scored"

echo "== the server is restored from a backup made before an attempt"
server_cli backup --data "$data" "$work/backup" >/dev/null
station_cli run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" --user student1 \
  --operator student --json "$work/cut.json" >/dev/null
attempt=$(json_of "$work/cut.json" attempt_id) ticks=$(json_of "$work/cut.json" ticks)
stop_server
server_cli restore --data "$work/restored" "$work/backup" >/dev/null
data=$work/restored
[ -z "$(ticks_on_server "$attempt")" ] || fail "the backup has an attempt that was made after it"
start_server "$data" "$port"
[ "$(spool_of "$attempt" state)" = uploaded ] || fail "expected the station to believe that all is well"
station_cli upload --data "$station" | tee "$work/upload.log"
grep -q "has lost 1 attempts" "$work/upload.log" || fail "the station did not hear of what the server lost"
[ "$(ticks_on_server "$attempt")" = "$ticks" ] || fail "of $ticks ticks the restored server has $(ticks_on_server "$attempt")"
server_cli report --data "$data" --attempt "$attempt" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" witness_ok)" = true ] || fail "what was sent again does not replay"
station_cli upload --data "$station" | grep -q "nothing to upload" || fail "there is still something to send"

echo "== an attempt without the server"
expect_failure "a PIN that is easy to guess" "easy to guess" \
  env ENAMEL_PIN=123456 "$bin/enamel-station" reserve --data "$station" --user student1 --exercise "$exercise" --profile phantom_desktop
export ENAMEL_PIN=804217
station_cli reserve --data "$station" --user student1 --exercise "$exercise" --profile phantom_desktop | tee "$work/reserve.log"
attempt=$(tail -n 1 "$work/reserve.log" | cut -d' ' -f1)

echo "== tickets that are not wanted any more do not count"
# given_back ID: how many times the server says so.
given_back() { server_cli admin list-attempts --data "$data" | grep "^$1 " | grep -c returned || true; }
reserve_another() {
  station_cli reserve --data "$station" --user student1 --exercise "$exercise" --profile phantom_desktop | grep -v "^$attempt" | tail -n 1 | cut -d' ' -f1
}
other=$(reserve_another)
expect_failure "a wrong PIN" "wrong PIN" env ENAMEL_PIN=804218 "$bin/enamel-station" reserve --data "$station" --give-back "$other"
[ "$(given_back "$other")" = 0 ] || fail "a wrong PIN has given a ticket back"
station_cli reserve --data "$station" --give-back "$other" | grep -q "no longer counts" || fail "it was not given back at once"
[ "$(given_back "$other")" = 1 ] || fail "the server does not know that a ticket was given back"
expect_failure "using it all the same" "given back" "$bin/enamel-station" run --data "$station" --lockstep --reserved "$other"
other=$(reserve_another)
stop_server
station_cli reserve --data "$station" --give-back "$other" | grep -q "could not be reached" || fail "who told the server?"
start_server "$data" "$port"
station_cli upload --data "$station" >/dev/null
[ "$(given_back "$other")" = 1 ] || fail "the server was not told later"
stop_server
unset ENAMEL_PASSWORD
expect_failure "a wrong PIN" "wrong PIN; 9 more" env ENAMEL_PIN=804218 "$bin/enamel-station" run --data "$station" --lockstep --reserved "$attempt"
rc=0
station_cli run --data "$station" --lockstep --quiet --operator student --reserved "$attempt" --json "$work/cut.json" || rc=$?
[ $rc -eq 3 ] || fail "expected exit code 3 (recorded, not uploaded), found $rc"
expect_failure "the same ticket again" "begun already" "$bin/enamel-station" run --data "$station" --lockstep --reserved "$attempt"
start_server "$data" "$port"
station_cli upload --data "$station" >/dev/null
[ "$(ticks_on_server "$attempt")" = "$(json_of "$work/cut.json" ticks)" ] || fail "the offline attempt is not whole at the server"
server_cli report --data "$data" --attempt "$attempt" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" witness_ok)" = true ] || fail "the offline attempt does not replay"

echo "== the cable is pulled again and again"
export ENAMEL_PASSWORD=enamel-demo-student1
cable_port=$(free_ports)
node "$root/tests/integration/cable.mjs" "$cable_port" "$((port + 1))" "$work/cut" >"$work/cable.log" &
cable=$!
pids+=("$cable")
wait_for_log "$work/cable.log" ready
before=$(newest "$station")
"$bin/enamel-station" run --data "$station" --server "127.0.0.1:$cable_port" --profile phantom_desktop --lockstep --quiet \
  --exercise "$exercise" --user student1 --operator student --json "$work/cut.json" >"$work/run.log" 2>&1 &
runner=$!
pids+=("$runner")
for _ in $(seq 3000); do [ "$(newest "$station")" = "$before" ] || break; done
touch "$work/cut"
rc=0
wait "$runner" || rc=$?
[ $rc -eq 0 ] || [ $rc -eq 3 ] || { cat "$work/run.log"; fail "the station ended with exit code $rc"; }
# What is left goes over the same bad cable, then over a whole one.
timeout 120 "$bin/enamel-station" upload --data "$station" --server "127.0.0.1:$cable_port" >/dev/null 2>&1 || true
rm "$work/cut"
station_cli upload --data "$station" --server "127.0.0.1:$cable_port" >/dev/null
cuts=$(tail -n 1 "$work/cable.log" | cut -d' ' -f1)
[ "$cuts" -ge 10 ] 2>/dev/null || fail "expected the cable to be cut at least 10 times, it was: $(tail -n 1 "$work/cable.log")"
attempt=$(json_of "$work/cut.json" attempt_id)
[ "$(ticks_on_server "$attempt")" = "$(json_of "$work/cut.json" ticks)" ] || fail "a pulled cable cost ticks"
server_cli report --data "$data" --attempt "$attempt" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" witness_ok)" = true ] || fail "what came over the broken cable does not replay"
[ "$(spool_of "$attempt" committed_chunks)" = "$(spool_of "$attempt" chunks)" ] || fail "parts of it are still on the station only"
echo "ok: $(json_of "$work/cut.json" ticks) ticks over $cuts cuts"
kill "$cable"

echo "== interrupted while the rest is sent to a server that answers nothing any more"
cable_port=$(free_ports)
# A log of its own: the earlier cable's "ready" is not this one's.
node "$root/tests/integration/cable.mjs" "$cable_port" "$((port + 1))" "$work/never" "$work/hold" >"$work/held_cable.log" &
cable=$!
pids+=("$cable")
wait_for_log "$work/held_cable.log" ready
for signal in INT TERM; do
  rm -f "$work/hold"
  before=$(newest "$station")
  "$bin/enamel-station" run --data "$station" --server "127.0.0.1:$cable_port" --profile phantom_desktop --lockstep --quiet \
    --exercise "$exercise" --user student1 --operator student --json "$work/cut.json" >"$work/run.log" 2>&1 &
  runner=$!
  pids+=("$runner")
  for _ in $(seq 3000); do [ "$(newest "$station")" = "$before" ] || break; done
  touch "$work/hold"
  attempt=$(newest "$station")
  [ "$attempt" != "$before" ] || { cat "$work/run.log"; fail "no attempt was begun"; }
  for _ in $(seq 600); do [ "$(spool_of "$attempt" state)" = unfinished ] || break; sleep 0.1; done
  [ "$(spool_of "$attempt" state)" = waiting ] || fail "recorded with a silent server it is $(spool_of "$attempt" state)"
  # An interrupt within 2 s of the end is one of the attempt. The station would wait 28 s for this server.
  sleep 2.5
  kill -0 "$runner" || { cat "$work/run.log"; fail "it did not wait for the server"; }
  interrupted_ms=$(date +%s%3N) rc=0
  kill "-$signal" "$runner"
  wait "$runner" || rc=$?
  took_ms=$(($(date +%s%3N) - interrupted_ms))
  [ $rc -eq 3 ] || { cat "$work/run.log"; fail "interrupted by $signal it ended with exit code $rc"; }
  [ "$took_ms" -le 10000 ] || fail "it went on for $took_ms ms after $signal"
  grep -q "not on the server yet (interrupted while it was being sent).*nothing is lost" "$work/run.log" ||
    { cat "$work/run.log"; fail "it does not say that it was interrupted"; }
  station_cli spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "the spool does not verify"; }
  [ "$(spool_of "$attempt" ticks)" = "$(json_of "$work/cut.json" ticks)" ] || fail "the spool has other ticks than were made"
  station_cli upload --data "$station" >/dev/null
  [ "$(ticks_on_server "$attempt")" = "$(json_of "$work/cut.json" ticks)" ] || fail "what was interrupted by $signal is not whole at the server"
  [ "$(spool_of "$attempt" state)" = uploaded ] || fail "it is $(spool_of "$attempt" state) after the upload"
  echo "ok: $signal ended the sending after $took_ms ms; all $(json_of "$work/cut.json" ticks) ticks came with the next upload"
done
kill "$cable"

echo "== watched while it is made"
"$bin/enamel-station" run --data "$station" --profile phantom_desktop --quiet --exercise "$exercise" --user student1 \
  --operator student >"$work/run.log" 2>&1 &
runner=$!
pids+=("$runner")
node "$root/tests/integration/watch.mjs" "$port" instructor enamel-demo-instructor 6 | tee "$work/watch.json"
kill -TERM "$runner"
rc=0
wait "$runner" || rc=$?
[ $rc -eq 3 ] || { cat "$work/run.log"; fail "the watched attempt was left with exit code $rc"; }
station_cli spool close last --data "$station" >/dev/null
node -e '
  const w = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  if (!(w.rows_per_second >= 30)) { console.error(`a viewer saw ${w.rows_per_second} moments a second, expected at least 30`); process.exit(1); }
' "$work/watch.json" || fail "the live view"

echo "== an exam, with a hand that is none"
server_cli report --data "$data" --attempt "$reference" --wait 1 --all >"$work/report.txt"
grep -q "held by.*a simulated hand (operator dentist)" "$work/report.txt" || { cat "$work/report.txt"; fail "the report does not say who held the tool"; }
server_cli admin assign-exercise --data "$data" --exercise "$exercise" --cohort "Demo cohort" --attempts 1 --exam |
  tee "$work/exam.txt"
expect_failure "an exam by a simulated hand" "haptic device on the school's list, found a simulated hand \(operator dentist\)" \
  "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" --user student1 \
  --operator dentist
server_cli admin end-assignment --data "$data" --assignment "$(cut -d ' ' -f 1 "$work/exam.txt")" | grep -q "was removed" ||
  fail "an attempt was begun under the exam all the same"
server_cli admin assign-exercise --data "$data" --exercise "$exercise" --cohort "Demo cohort" --attempts 1 --exam --hands any >/dev/null
station_cli run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" --user student1 \
  --operator student --json "$work/cut.json" >/dev/null

station_cli spool verify --data "$station" | tail -n 1
stop_server
echo "nothing lost: resumed, closed, restored, offline, interrupted and over a broken cable"
