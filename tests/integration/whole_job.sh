#!/usr/bin/env bash
# ./run --once, again, then ./run with the page looked at in a browser, Ctrl-C, and again: attempts still there.
. "$(dirname "$0")/support.sh"
cd "$root"
port=$(free_ports)

./run --once --data "$work/data" --port "$port" --json "$work/1.json"
node tests/integration/check_facts.mjs "$work/1.json"
first=$(node -p "JSON.parse(require('fs').readFileSync('$work/1.json','utf8')).attempt_id")
reference=$(node -p "JSON.parse(require('fs').readFileSync('$work/1.json','utf8')).reference_id")

# The reference against itself: full marks, no deviation.
"$bin/enamel-server" report --data "$work/data/server" --attempt "$reference" --json "$work/reference.json" >/dev/null
node -e '
  const f = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  if (f.score !== 100 || f.deviation_rms_mm !== 0) { console.error("reference against itself:", f.score, f.deviation_rms_mm); process.exit(1); }
' "$work/reference.json" || fail "the reference is not its own equal"

# What the station recorded re-runs to the same bits, here and in a core built by the other compiler.
"$bin/enamel-station" spool verify --data "$work/data/station"
"$bin/enamel-station" spool export --data "$work/data/station" "$first" --out "$work/first.trace"
volume=$(for blob in "$work"/data/station/blobs/*; do [ "$(head -c 4 "$blob")" = ENVB ] && echo "$blob"; done | head -n 1)
[ -n "$volume" ] || fail "no volume blob among the station's"
build/release/bin/core_replay replay "$work/first.trace" "$volume" | tee "$work/replay.a"
grep -q '^witness_ok 1' "$work/replay.a" || fail "the exported recording does not re-run to its witness"
other=build/core-clang-O0/bin/core_replay
if [ -x $other ]; then
  $other replay "$work/first.trace" "$volume" >"$work/replay.b"
  cmp "$work/replay.a" "$work/replay.b" || fail "g++ -O3 and clang++ -O0 disagree on a recorded attempt"
fi

./run --once --data "$work/data" --port "$port" --json "$work/2.json"
node tests/integration/check_facts.mjs "$work/2.json"

./run --data "$work/data" --port "$port" >"$work/run.log" 2>&1 &
runner=$!
pids+=("$runner")
for _ in $(seq 3000); do
  grep -q 'Running until Ctrl-C' "$work/run.log" && break
  kill -0 "$runner" 2>/dev/null || { cat "$work/run.log"; fail "./run ended early"; }
  sleep 0.1
done
if [ -x /usr/bin/chromium ]; then
  BASE_URL="http://127.0.0.1:$port" STUDENT_LOGIN=student1 STUDENT_PASSWORD=enamel-demo-student1 \
    INSTRUCTOR_LOGIN=instructor INSTRUCTOR_PASSWORD=enamel-demo-instructor ADMIN_LOGIN=admin \
    ADMIN_PASSWORD=enamel-demo-admin FOREIGN_ATTEMPT="$reference" node tests/e2e/run.mjs
else
  echo "skipped: no chromium; the page was not looked at"
fi
# bash ignores INT in background jobs, so the test asks with TERM; Ctrl-C takes the same way out.
kill -TERM "$runner"
rc=0
wait "$runner" || rc=$?
[ $rc -eq 143 ] || { cat "$work/run.log"; fail "./run ended with exit code $rc on TERM"; }

"$bin/enamel-server" admin list-attempts --data "$work/data/server" >"$work/list"
for id in "$first" "$reference" "$(node -p "JSON.parse(require('fs').readFileSync('$work/2.json','utf8')).attempt_id")"; do
  grep -q "$id" "$work/list" || { cat "$work/list"; fail "attempt $id is gone"; }
done
echo "whole job done"
