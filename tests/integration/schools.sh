#!/usr/bin/env bash
# Two schools on one installation, as who runs it meets them: each with its host name, its people and its stations. What one
# has is nowhere in the other; one is suspended while a station uploads and loses nothing; it is exported, restored as an
# installation of its own, and deleted. With PostgreSQL and S3 stores (ENAMEL_POSTGRES, ENAMEL_S3_ENDPOINT) the installation
# has a second server, which follows.
. "$(dirname "$0")/support.sh"
data=$work/installation north=$work/installation/schools/north
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-student1
stores=()
[ -z "${ENAMEL_POSTGRES:-}" ] || stores=(--database "$ENAMEL_POSTGRES" --schema several --s3-endpoint "$ENAMEL_S3_ENDPOINT"
  --s3-bucket "$ENAMEL_S3_BUCKET" --s3-region "$ENAMEL_S3_REGION" --key-bucket keys --master-key "$work/master.key")
cli() { "$bin/enamel-server" "$@"; }
cli init --data "$data" ${stores[@]+"${stores[@]}"} >/dev/null
cli seed-demo --data "$data" --voxel-um 150 --json "$work/own-seed" >/dev/null
expect_failure "a school without a host name" "host" "$bin/enamel-server" school add north --data "$data"
expect_failure "a school's name with a slash" "a-z 0-9" "$bin/enamel-server" school add ../north --host north.test --data "$data"
expect_failure "a host name with a port" "without port" "$bin/enamel-server" school add north --host north.test:80 --data "$data"
[ ! -e "$data/schools" ] || fail "a folder was made for a school that was refused"
start_server "$data" "$port"
first=$server

# ask HOST PATH [options]: prints the status. From the second server where there is one.
page=$port
ask() {
  local host=$1 path=$2
  shift 2
  curl -s -o "$work/answer" -w '%{http_code}' -H "Host: $host" "$@" "http://127.0.0.1:$page$path"
}
# until_answer HOST STATUS: a server looks at the list every two seconds.
until_answer() {
  for _ in $(seq 300); do
    [ "$(ask "$1" /api/v1/session)" != "$2" ] || return 0
    sleep 0.1
  done
  fail "$1 was not answered with $2 within 30 s: $(cat "$work/answer")"
}
[ "$(ask north.test /api/v1/session)" = 421 ] || fail "somebody's name is answered: $(cat "$work/answer")"
cli school add north --host north.test --admin anna --data "$data" >"$work/added"
grep -q 'password' "$work/added" || { cat "$work/added"; fail "its admin has no password"; }
expect_failure "its name once more" "already" "$bin/enamel-server" school add north --host south.test --data "$data"
expect_failure "its host name once more" "north's" "$bin/enamel-server" school add south --host north.test --data "$data"
until_answer north.test 401
cli seed-demo --data "$north" --voxel-um 150 --json "$work/north-seed" >/dev/null
expect_failure "a server on a school's folder" "found a school's" "$bin/enamel-server" serve --data "$north" --http 127.0.0.1:0 --stations 127.0.0.1:0
expect_failure "a school of a school" "found a school's" "$bin/enamel-server" school add south --host south.test --data "$north"
link=$((port + 1))
if [ -n "${ENAMEL_POSTGRES:-}" ]; then
  mkdir "$work/identity"
  cp "$data"/station.crt "$data"/station.key "$data"/ticket.key "$work/identity"
  cli init --data "$work/second" "${stores[@]}" --identity "$work/identity" >/dev/null
  page=$(free_ports) link=$((page + 1))
  start_server "$work/second" "$page"
  until_answer north.test 401
  cmp "$north/ticket.key" "$work/second/schools/north/ticket.key" || fail "the two servers sign for the school with two keys"
fi

# sign_in HOST: the session's cookie into $work/HOST.jar.
sign_in() {
  [ "$(ask "$1" /api/v1/session -c "$work/$1.jar" -H 'Content-Type: application/json' \
    -d '{"login": "student1", "password": "enamel-demo-student1"}')" = 200 ] || fail "nobody signs in at $1: $(cat "$work/answer")"
}
sign_in localhost
sign_in north.test
cookie=$(awk '$6 == "enamel_session" {print $7}' "$work/localhost.jar")
[ "$(ask north.test /api/v1/session -H "Cookie: enamel_session=$cookie")" = 401 ] || fail "a session of one school is one of the other"
[ "$(ask localhost /api/v1/session -H "Cookie: enamel_session=$cookie")" = 200 ] || fail "the session is nobody's"

# A station of each.
for school in own north; do
  folder=$data
  [ $school = own ] || folder=$north
  "$bin/enamel-station" enrol --data "$work/$school" --server "127.0.0.1:$link" --name "$school" --code "$(cli admin enrol-code --data "$folder")" >/dev/null
  run=("$bin/enamel-station" run --data "$work/$school" --profile phantom_desktop --lockstep --quiet --exercise "$(json_of "$work/$school-seed" exercise)")
  ENAMEL_PASSWORD=enamel-demo-instructor "${run[@]}" --user instructor --operator dentist --as-reference --json "$work/$school-cut" >/dev/null
  cli report --data "$folder" --attempt "$(json_of "$work/$school-cut" attempt_id)" --wait 600 --json "$work/$school-report" >/dev/null
  [ "$(json_of "$work/$school-report" ticks)" = "$(json_of "$work/$school-cut" ticks)" ] || fail "$school has not all ticks"
done
cli admin mark-reference --data "$north" --attempt "$(json_of "$work/north-cut" attempt_id)" --dentist "Simulated dentist" --consent >/dev/null
for pair in "own $north" "north $data"; do
  read -r school folder <<<"$pair"
  expect_failure "$school's attempt in the other school" "no attempt|not found|there is no" "$bin/enamel-server" report --data "$folder" \
    --attempt "$(json_of "$work/$school-cut" attempt_id)"
done
attempt=$(json_of "$work/north-cut" attempt_id)
sign_in_as_instructor() {
  [ "$(ask "$1" /api/v1/session -c "$work/jar" -H 'Content-Type: application/json' \
    -d '{"login": "instructor", "password": "enamel-demo-instructor"}')" = 200 ] || fail "the instructor of $1 is not let in"
  cookie=$(awk '$6 == "enamel_session" {print $7}' "$work/jar")
}
sign_in_as_instructor localhost
[ "$(ask localhost "/api/v1/attempts/$attempt" -H "Cookie: enamel_session=$cookie")" = 404 ] || fail "another school's attempt is shown"
sign_in_as_instructor north.test
[ "$(ask north.test "/api/v1/attempts/$attempt" -H "Cookie: enamel_session=$cookie")" = 200 ] || fail "the school's own attempt is not shown: $(cat "$work/answer")"
[ "$(ask north.test /metrics)" = 200 ] && grep -q '^enamel_attempts_sealed_total 1$' "$work/answer" || { cat "$work/answer"; fail "the school's own figures are not shown"; }
echo "ok: two schools, each with its people, its station and its attempts"

# A station's id is no secret: who enrols it in another school takes nobody's place.
cp -r "$work/own" "$work/copy"
"$bin/enamel-station" enrol --again --data "$work/copy" --server "127.0.0.1:$link" --code "$(cli admin enrol-code --data "$north")" >/dev/null
"$bin/enamel-station" upload --data "$work/own" >/dev/null || fail "a station is kept out by another school that enrolled its id"

# Suspended while its station uploads.
run=("$bin/enamel-station" run --data "$work/north" --profile phantom_desktop --lockstep --quiet --exercise "$(json_of "$work/north-seed" exercise)")
"${run[@]}" --user student1 --operator good --uplink-kbit 200 --json "$work/slow" >"$work/run.log" 2>&1 &
cutting=$!
pids+=("$cutting")
wait_for_log "$work/run.log" "begins"
cli school suspend north --data "$data" >/dev/null
until_answer north.test 503
ended=0
wait "$cutting" || ended=$?
[ $ended = 3 ] || { cat "$work/run.log"; fail "the station ended with $ended while its school was suspended, expected 3 (not on the server yet)"; }
[ "$(ask localhost /api/v1/session -H "Cookie: enamel_session=$(awk '$6 == "enamel_session" {print $7}' "$work/localhost.jar")")" = 200 ] ||
  fail "the other school is suspended too"
expect_failure "an upload to a suspended school" "suspended" "$bin/enamel-station" upload --data "$work/north"
cli school resume north --data "$data" >/dev/null
until_answer north.test 401
"$bin/enamel-station" upload --data "$work/north" >/dev/null
slow=$(json_of "$work/slow" attempt_id)
cli report --data "$north" --attempt "$slow" --wait 600 --json "$work/slow-report" >/dev/null
[ "$(json_of "$work/slow-report" ticks)" = "$(json_of "$work/slow" ticks)" ] || fail "ticks were lost while the school was suspended"
echo "ok: suspended while a station uploads, and nothing is lost"

cli school export north --to "$work/export" --data "$data" >/dev/null
[ ! -e "$work/export/station.key" ] || fail "the installation's key went along"
cli restore "$work/export" --data "$work/restored" >/dev/null
cli report --data "$work/restored" --attempt "$slow" --json "$work/restored-report" >/dev/null
cmp "$work/slow-report" "$work/restored-report" || fail "the restored school's report is another"

if [ -z "${ENAMEL_POSTGRES:-}" ]; then
  # Its folder is away for a while: nothing is made in its place.
  cli school suspend north --data "$data" >/dev/null
  until_answer north.test 503
  # Its jobs end after that answer. What one writes into a folder that has been moved is lost with it.
  for _ in $(seq 600); do
    ls -l "/proc/$server/fd" | grep -q " $north/" || break
    sleep 0.1
  done
  ! ls -l "/proc/$server/fd" | grep -q " $north/" || fail "a suspended school's files are still open after a minute"
  mv "$north" "$work/away"
  cli school resume north --data "$data" >/dev/null
  wait_for_log "$work/server.log" 'north is not in'
  [ "$(ask north.test /api/v1/session)" = 503 ] && grep -q 'cannot be reached' "$work/answer" || fail "a school without its data: $(cat "$work/answer")"
  [ ! -e "$north/enamel.db" ] || fail "a school was made in the place of one that is away"
  "$bin/enamel-station" upload --data "$work/own" >/dev/null || fail "a school that is away keeps another's station out"
  rm -rf "$north"
  mv "$work/away" "$north"
  until_answer north.test 401
  # A backup of the installation has the list, and not the schools.
  cli backup "$work/backup" --data "$data" >/dev/null
  cli restore "$work/backup" --data "$work/whole" >"$work/restored-out"
  grep -q 'north is listed and suspended' "$work/restored-out" || { cat "$work/restored-out"; fail "a restore says nothing of the other schools"; }
  cli school list --data "$work/whole" | grep -q 'suspended' || fail "a restored installation would serve a school without its data"
  echo "ok: a school whose data is not there is not made anew"
  # What the timer runs: every school, each into a folder of its own.
  expect_failure "no folder for backups" "mount its disk" "$bin/enamel-server" backup --into "$work/backups" --data "$data"
  mkdir "$work/backups"
  cli backup --into "$work/backups" --data "$data" >/dev/null
  cli verify "$work"/backups/schools/north/20* >/dev/null || fail "the timer's backup of another school does not verify"
  cli verify "$work"/backups/20* >/dev/null || fail "the timer's backup of the installation does not verify"
  # One that fails is said, and keeps no other from its own.
  mv "$north" "$work/away"
  rm -rf "$work"/backups/*
  expect_failure "a school without its data" "school north" "$bin/enamel-server" backup --into "$work/backups" --data "$data"
  mv "$work/away" "$north"
  cli verify "$work"/backups/20* >/dev/null || fail "a school that is away keeps the installation from its backup"
  echo "ok: every school has its backup"
fi
# A stream that is open ends with its school.
sign_in_as_instructor north.test
curl -sN -H "Host: north.test" -H "Cookie: enamel_session=$cookie" "http://127.0.0.1:$page/api/v1/attempts/$attempt/live" >"$work/stream" 2>&1 &
pids+=($!)

expect_failure "a school that is served" "suspend" "$bin/enamel-server" school delete north --confirm north --data "$data"
cli school suspend north --data "$data" >/dev/null
expect_failure "without its name" "--confirm north" "$bin/enamel-server" school delete north --data "$data"
cli school delete north --confirm north --data "$data" >/dev/null
[ ! -e "$north" ] || fail "its folder is still there"
until_answer north.test 421
if [ -n "${ENAMEL_POSTGRES:-}" ]; then
  [ "$(psql -X -A -t -d "$ENAMEL_POSTGRES" -c "SELECT count(*) FROM information_schema.schemata WHERE schema_name = 'several_north'")" = 0 ] ||
    fail "its rows are still there"
  for _ in $(seq 300); do
    [ -e "$work/second/schools/north" ] || break
    sleep 0.1
  done
  [ ! -e "$work/second/schools/north" ] || fail "the other server has its folder still"
fi
cli report --data "$data" --attempt "$(json_of "$work/own-cut" attempt_id)" --json "$work/own-again" >/dev/null
cmp "$work/own-report" "$work/own-again" || fail "the other school's report is another now"
cli school add north --host north.test --data "$data" >/dev/null
until_answer north.test 401
expect_failure "an attempt from before" "no attempt|not found|there is no" "$bin/enamel-server" report --data "$north" --attempt "$slow"
echo "ok: exported, restored, deleted, and made again under its old name"
[ "$first" = "$server" ] || stop_server
server=$first
stop_server
[ -n "${ENAMEL_POSTGRES:-}" ] || expect_failure "a move of an installation with others" "1 other school" "$bin/enamel-server" move --data "$data" --to "$work/moved"
