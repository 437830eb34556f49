#!/usr/bin/env bash
# ./run --once, again, then ./run with Ctrl-C at every stage, and again: attempts still there.
. "$(dirname "$0")/support.sh"
cd "$root"
port=$(free_ports)
school=(--data "$work/data/server")

mkdir "$work/folder"
for bad in "$work/none/x.json" "$work/folder"; do
  expect_failure "facts to $(basename "$bad")" "json.*$(basename "$bad")" ./run --once --data "$work/data" --port "$port" --json "$bad"
done
[ ! -e "$work/data/server" ] || fail "a refused ./run has begun its work"

./run --once --data "$work/data" --port "$port" --json "$work/1.json" | tee "$work/once"
# What a newcomer reads: the mistake that was made, what to do about it, and nothing else at length.
sed '1,/^==> score/d' "$work/once" >"$work/score"
grep -qE -- '-[0-9]+\.[0-9] +Mesial wall: over-extended by 0\.(2[5-9]|3[0-4]) mm' "$work/score" && grep -q '^Next time: ' "$work/score" ||
  fail "expected the mesial wall and its remedy in the report"
[ "$(wc -l <"$work/score")" -le 14 ] && ! grep -qE '.{121}' "$work/score" || fail "expected a short report, found $(cat "$work/score")"
node tests/integration/check_facts.mjs "$work/1.json"
first=$(node -p "JSON.parse(require('fs').readFileSync('$work/1.json','utf8')).attempt_id")
# The other attempt of the demo; the student's may have been judged by the exercise's own target.
"$bin/enamel-server" admin list-attempts --data "$work/data/server" >"$work/list"
reference=$(grep -oE '[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}' "$work/list" | grep -v "$first" | head -1)

# The reference against itself: full marks, no deviation.
"$bin/enamel-server" report --data "$work/data/server" --attempt "$reference" --json "$work/reference.json" >/dev/null
node -e '
  const f = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  if (f.score !== 100 || f.deviation_rms_mm !== 0) { console.error("reference against itself:", f.score, f.deviation_rms_mm); process.exit(1); }
' "$work/reference.json" || fail "the reference is not its own equal"

# What the station recorded re-runs to the same bits, here and in a core built by the other compiler.
"$bin/enamel-station" spool verify --data "$work/data/station"
"$bin/enamel-station" spool export --data "$work/data/station" "$first" --out "$work/first.trace"
volume=""
for blob in "$work"/data/station/blobs/*; do
  if [ "$(head -c 4 "$blob" | tr -d '\0')" = ENTV ]; then volume=$blob; fi
done
[ -n "$volume" ] || fail "no volume blob among the station's"
"$bin/core_replay" replay "$work/first.trace" "$volume" | tee "$work/replay.a"
grep -q '^witness_ok 1' "$work/replay.a" || fail "the exported recording does not re-run to its witness"
other=build/core-clang-O0/bin/core_replay
if [ -x $other ]; then
  $other replay "$work/first.trace" "$volume" >"$work/replay.b"
  cmp "$work/replay.a" "$work/replay.b" || fail "g++ -O3 and clang++ -O0 disagree on a recorded attempt"
fi

./run --once --data "$work/data" --port "$port" --json "$work/2.json"
node tests/integration/check_facts.mjs "$work/2.json"

# A rubric is corrected: the preview says what the new runs then find. Before there are many attempts to score again.
start_server "$work/data/server" "$port"
"$bin/enamel-server" admin show-rubric "${school[@]}" --exercise class-1-molar-46 --out "$work/rubric.json"
node -e '
  const fs = require("fs"), file = process.argv[1], rubric = JSON.parse(fs.readFileSync(file, "utf8"));
  rubric.prices.find((each) => each.of === "wall").points /= 2;
  fs.writeFileSync(file, JSON.stringify(rubric));
' "$work/rubric.json"
"$bin/enamel-server" admin publish-rubric "${school[@]}" --exercise class-1-molar-46 --document "$work/rubric.json" --preview >"$work/preview"
"$bin/enamel-server" admin publish-rubric "${school[@]}" --exercise class-1-molar-46 --document "$work/rubric.json" --reason "walls cost half as much"
"$bin/enamel-server" rescore "${school[@]}" --cohort "Demo cohort"
"$bin/enamel-server" admin list-attempts "${school[@]}" >"$work/list"
for id in $(grep -oE '^[0-9a-f]{8}-[0-9a-f-]{27}' "$work/list"); do
  "$bin/enamel-server" report "${school[@]}" --attempt "$id" --wait 120 --json "$work/regraded_$id.json" >/dev/null || true
done
before=$(awk -v id="$first" '$1 == id { print $2 }' "$work/preview")
after=$(awk -v id="$first" '$1 == id { print $3 }' "$work/preview")
node -e '
  const f = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8")), [before, after] = process.argv.slice(2).map(Number);
  const fits = after > before && Math.abs(f.score - after) < 0.06 && f.result.signed;
  if (!fits) { console.error("preview", before, "to", after, "then", f.score, f.result); process.exit(1); }
' "$work/regraded_$first.json" "$before" "$after" || { cat "$work/preview"; fail "the new run is not what the preview said"; }
echo "ok: a corrected rubric counts in the next run as its preview said ($before to $after)"
stop_server

# As a terminal starts it: a process group of its own that heeds Ctrl-C.
start_run() {
  env -u DISPLAY --default-signal=INT,TERM setsid ./run --data "$work/data" --port "$port" >"$work/run.log" 2>&1 &
  runner=$!
  pids+=("$runner")
}
wait_for_line() {
  for _ in $(seq 18000); do
    grep -q "$1" "$work/run.log" && return
    kill -0 "$runner" 2>/dev/null || { cat "$work/run.log"; fail "./run ended before it said \"$1\""; }
    sleep 0.05
  done
  cat "$work/run.log"
  fail "./run did not say \"$1\" within 900 s"
}
wait_for_ticks() {
  wait_for_line "attempt by a simulated student"
  until "$bin/enamel-station" spool list --data "$work/data/station" | tail -n 1 | grep -qE 'unfinished .* [1-9][0-9]* of'; do
    ! grep -q '==> score' "$work/run.log" || return
    kill -0 "$runner" 2>/dev/null || { cat "$work/run.log"; fail "./run ended before the attempt"; }
    sleep 0.1
  done
}
# An impatient Ctrl-C: whole group, three times.
press_ctrl_c() {
  local rc=0
  kill -INT -- "-$runner"
  for _ in 1 2; do sleep 0.2; kill -INT -- "-$runner" 2>/dev/null || true; done
  wait "$runner" || rc=$?
  [ $rc -eq 130 ] || { cat "$work/run.log"; fail "./run ended with exit code $rc on Ctrl-C, expected 130"; }
  # A busy computer scores for longer than a server that is to stop waits.
  grep -qE '\] (stopped|stopping in the middle of a job:.*)$' "$work/data/server.log" || { cat "$work/data/server.log"; fail "the server was not stopped cleanly"; }
  "$bin/enamel-server" admin list-attempts --data "$work/data/server" >"$work/list"
  # Stopped in the middle, the job goes on at the next start.
  local left='being scored|failed'
  ! grep -q 'stopping in the middle of a job' "$work/data/server.log" || left='failed'
  ! grep -qE " ($left) " "$work/list" || { cat "$work/list"; fail "a job was left behind"; }
}

start_run
wait_for_ticks
press_ctrl_c
"$bin/enamel-station" spool list --data "$work/data/station" >"$work/spool"
grep -q "; 0 with something the server does not have" "$work/spool" || fail "Ctrl-C left a recording on the station while the server was there"
if grep -q "left before its end" "$work/run.log"; then
  grep -q unfinished "$work/spool" || { cat "$work/spool"; fail "what Ctrl-C left cannot be resumed"; }
  echo "ok: Ctrl-C in an attempt: $(grep -m1 'left before its end' "$work/run.log" | cut -c1-120)"
  "$bin/enamel-station" spool close last --data "$work/data/station" >/dev/null  # the next ./run sends its end
fi

start_run
wait_for_line "==> score"
press_ctrl_c
echo "ok: Ctrl-C while scoring"

# The server dies in an attempt: the next ./run brings what the station kept.
start_run
wait_for_ticks
server_pid=$(pgrep -f "^build/release/bin/enamel-server serve --data $work/data/server ")
kill -KILL "$server_pid"
rc=0
wait "$runner" || rc=$?
[ $rc -ne 0 ] || fail "./run ended with exit code 0 without its server"
left=$("$bin/enamel-station" spool list --data "$work/data/station" | grep '; [1-9][0-9]* with something the server does not have') || true

start_run
wait_for_line 'Running until Ctrl-C'
# The command that it prints where there is no screen opens the chair's window.
if command -v Xvfb >/dev/null; then
  start_display
  printf 'page sign-in\nquit\n' >"$work/chair.txt"
  eval "timeout 300 $(sed -n 's/^At a screen: //p' "$work/run.log") --no-sound --script $work/chair.txt" ||
    { cat "$work/run.log"; fail "the command that ./run prints opens no window"; }
fi
if [ -n "$left" ]; then
  grep -q "sent what an earlier run recorded" "$work/run.log" || { cat "$work/run.log"; fail "./run did not send the recording that was left"; }
  echo "ok: ./run sends what an earlier one could not"
fi
"$bin/enamel-station" spool list --data "$work/data/station" | grep -q '; 0 with something the server does not have' || fail "a recording is still only on the station"
press_ctrl_c

"$bin/enamel-server" verify "${school[@]}" >"$work/verify" || { cat "$work/verify"; fail "verify finds something in what nobody touched"; }
grep -qE '[1-9][0-9]* signed result' "$work/verify" || { cat "$work/verify"; fail "no result is signed"; }

# Out of the house: whoever has the export checks each result without the server, by our program or by the script.
"$bin/enamel-server" admin export-person "$work/mine" "${school[@]}" --login student1
key=$("$bin/enamel-server" admin list-stations "${school[@]}" | sed -nE "s/^key of this server's tickets and results +//p")
for result in "$work"/mine/attempts/*/result.bin; do
  "$bin/enamel-server" verify-result "$result" --key "$key" >"$work/checked" || { cat "$work/checked"; fail "$result does not verify"; }
  grep -q "^fingerprint $(sha256sum "$result" | cut -c 1-64)," "$work/checked" || { cat "$work/checked"; fail "another fingerprint"; }
  ! grep -q 'not there' "$work/checked" || { cat "$work/checked"; fail "the export lacks what its result binds"; }
  if python3 -c 'import cryptography' 2>/dev/null; then
    python3 -B schemas/verify_result.py "$result" "$key" >/dev/null || fail "the script refuses $result"
  fi
done
echo " " >>"$work/mine/attempts/$first/score.json"
expect_failure "an edited score" "not what was signed" "$bin/enamel-server" verify-result "$work/mine/attempts/$first/result.bin"
if python3 -c 'import cryptography' 2>/dev/null; then
  expect_failure "an edited score" "REFUSED: score.json" python3 -B schemas/verify_result.py "$work/mine/attempts/$first/result.bin"
fi
echo "ok: results are checked outside the house"

"$bin/enamel-server" admin list-attempts --data "$work/data/server" >"$work/list"
for id in "$first" "$reference" "$(node -p "JSON.parse(require('fs').readFileSync('$work/2.json','utf8')).attempt_id")"; do
  grep -q "$id" "$work/list" || { cat "$work/list"; fail "attempt $id is gone"; }
done
echo "whole job done"
