#!/usr/bin/env bash
# Workers of their own score what the server leaves to them; one after the other is killed in the midst of it, and each
# attempt has one new result all the same, equal to the one before. with_postgres.sh starts PostgreSQL.
# Usage: workers.sh [ATTEMPTS [RUNS OF EACH [WORKERS]]]
. "$(dirname "$0")/support.sh"
attempts=${1:-3} runs=${2:-1} many=${3:-2} data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor
"$bin/enamel-server" init --data "$data" --database "$ENAMEL_POSTGRES" --schema workers
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 150 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port" --job-threads 0
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" --name workers
declare -a ids workers
run() {
  "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" \
    --json "$work/cut.json" "$@" >/dev/null
  ids+=("$(json_of "$work/cut.json" attempt_id)")
}
start_worker() {
  "$bin/enamel-server" work --data "$data" >>"$work/worker.log" 2>&1 &
  workers+=($!)
  pids+=($!)
}
run --user instructor --operator dentist --as-reference
export ENAMEL_PASSWORD=enamel-demo-student1
for ((i = 1; i <= attempts; ++i)); do run --user student1 --operator good --seed "$i"; done

count() { PGOPTIONS="-c search_path=workers" psql -X -A -t -d "$ENAMEL_POSTGRES" -c "$1"; }
[ "$(count "SELECT count(*) FROM attempts WHERE state = 3")" = $((attempts + 1)) ] || fail "a server without job threads scored an attempt"
start_worker
score_of() {
  "$bin/enamel-server" report --data "$data" --attempt "$1" --wait 300 --json "$work/r.json" >/dev/null || fail "attempt $1 has no score"
  json_of "$work/r.json" score
}
score_of "${ids[0]}" >/dev/null
"$bin/enamel-server" admin mark-reference --data "$data" --attempt "${ids[0]}" --dentist "Simulated dentist" --consent >/dev/null
declare -A before
for id in "${ids[@]}"; do before[$id]=$(score_of "$id"); done

for ((i = 1; i < many; ++i)); do start_worker; done
jobs=$(count "SELECT count(*) FROM jobs") results=$(count "SELECT count(*) FROM attempt_results") kills=0
for ((round = 0; round < runs; ++round)); do
  "$bin/enamel-server" rescore --data "$data" --cohort "Demo cohort" >/dev/null
  # As soon as a job runs its worker may be the one that is killed; others take its job when the lease ends.
  deadline=$((SECONDS + 300))
  until [ "$(count "SELECT count(*) FROM jobs WHERE state IN ('queued', 'running')")" = 0 ]; do
    [ $SECONDS -lt $deadline ] || fail "jobs still wait after 300 s: $(count "SELECT count(*) FROM jobs WHERE state = 'queued'") queued"
    if [ "$kills" -lt $((2 * (round + 1))) ] && [ "$(count "SELECT count(*) FROM jobs WHERE state = 'running'")" != 0 ]; then
      kill -9 "${workers[0]}"; wait "${workers[0]}" 2>/dev/null || true
      workers=("${workers[@]:1}")
      kills=$((kills + 1))
      start_worker
    fi
  done
done
jobs=$(($(count "SELECT count(*) FROM jobs") - jobs)) results=$(($(count "SELECT count(*) FROM attempt_results") - results))
[ "$jobs" -ge $((attempts * runs)) ] || fail "only $jobs jobs were queued"
[ "$results" = "$jobs" ] || fail "expected one result of each of $jobs jobs, found $results"
for id in "${ids[@]}"; do
  [ "$(score_of "$id")" = "${before[$id]}" ] || fail "attempt $id: scored ${before[$id]} before and $(score_of "$id") after"
done
failed=$(count "SELECT count(*) FROM jobs WHERE state = 'failed'")
[ "$failed" = 0 ] || fail "$failed jobs failed"
echo "ok: $jobs jobs, $kills workers killed in the midst of one: a result each, and the same scores"
