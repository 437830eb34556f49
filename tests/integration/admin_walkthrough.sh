#!/usr/bin/env bash
# As an admin would (docs/for_it.md): first start, first admin, a cohort of 144 from
# CSV, stations enrolled, a device profile checked, an exercise assigned and done, backup, restore into an empty
# folder, verify; and nothing that is secret in the server's log at its most talkative.
. "$(dirname "$0")/support.sh"
port=$(free_ports)
data=$work/data
server=""
admin() { "$bin/enamel-server" admin "$@" --data "$data"; }
step() { printf '\n==> %s\n' "$*"; }
secrets=$work/secrets  # one a line: what must not be found
keep_secret() { printf '%s\n' "$1" >>"$secrets"; }

# api WHO METHOD PATH [BODY [TYPE]]: as the browser of WHO, who keeps cookie and csrf in $work/WHO.json; prints
# "STATUS BODY". WHO signs in with: api WHO POST /api/v1/session '{"login":…}'.
cat >"$work/api.mjs" <<'JS'
import { readFileSync, writeFileSync, existsSync } from 'node:fs';
const [base, file, method, path, body, type] = process.argv.slice(2);
const pass = existsSync(file) ? JSON.parse(readFileSync(file, 'utf8')) : {};
const headers = { 'Content-Type': type || 'application/json' };
if (pass.cookie) headers.Cookie = pass.cookie;
if (pass.csrf) headers['X-Enamel-Csrf'] = pass.csrf;
if (process.env.IF_MATCH) headers['If-Match'] = process.env.IF_MATCH;
const text = body?.startsWith('@') ? readFileSync(body.slice(1)) : body;
const answer = await fetch(base + path, { method, headers, body: method === 'GET' ? undefined : text || undefined });
const reply = await answer.text();
const cookie = answer.headers.get('set-cookie');
if (cookie && answer.ok) {
  writeFileSync(file, JSON.stringify({ cookie: cookie.split(';')[0], csrf: reply ? JSON.parse(reply).csrf : '' }));
}
console.log(answer.status + ' ' + reply);
JS
api() { local who=$1; shift; node "$work/api.mjs" "http://127.0.0.1:$port" "$work/$who.json" "$@"; }
# expect STATUS WHO METHOD PATH…: the body, when the status is this one.
expect() {
  local wanted=$1 answer
  shift
  answer=$(api "$@")
  [ "${answer%% *}" = "$wanted" ] || fail "$*: expected $wanted, found $answer"
  echo "${answer#* }"
}
member() { node -p 'eval("(" + process.argv[1] + ")")'"$2" "$1"; }

step "first start, first admin"
start_server "$data" "$port" --log-level debug
printf 'a long enough admin password\n' | admin add-person --login head --name "Head of Skills Lab" --role admin --password-stdin
keep_secret "a long enough admin password"
expect 200 head POST /api/v1/session '{"login":"head","password":"a long enough admin password"}' >/dev/null
keep_secret "$(node -p 'JSON.parse(require("fs").readFileSync(process.argv[1])).cookie.split("=")[1]' "$work/head.json")"

step "a cohort of 144 from a spreadsheet"
awk 'BEGIN {
  print "login,display_name,role,cohort";
  for (i = 1; i <= 144; ++i) {
    name = "Student " i;
    if (i % 9 == 0) name = "\"Müller, Zoë " i "\"";
    if (i % 13 == 0) name = "\"Jo \"\"Joe\"\" " i "\"";
    printf "s%03d,%s,student,Year 3\r\n", i, name;
  }
  for (i = 1; i <= 4; ++i) printf "teacher%d,Teacher %d,instructor,Year 3\r\n", i, i;
}' >"$work/year3.csv"
{ cat "$work/year3.csv"; printf 's145,=cmd(),student,Year 3\r\ns001,Again,dean,Year 3\r\n'; } >"$work/wrong.csv"
sed 's/,/;/g' "$work/year3.csv" >"$work/semicolons.csv"
expect_failure "a roster with three things wrong" "row 150, display_name: found \"=cmd\(\)\"" \
  "$bin/enamel-server" admin import-roster "$work/wrong.csv" --data "$data"
admin import-roster "$work/semicolons.csv" --dry-run --json "$work/semicolons.json"
[ "$(json_of "$work/semicolons.json" created)" = 148 ] || fail "a roster with semicolons reads otherwise"
admin import-roster "$work/year3.csv" --dry-run --json "$work/dry.json"
[ "$(json_of "$work/dry.json" created)" = 148 ] || fail "the dry run does not say 148"
[ "$(admin list-people | wc -l)" = 1 ] || fail "refused and dry runs made people"
expect_failure "passwords nowhere to go" "--passwords FILE.csv" \
  "$bin/enamel-server" admin import-roster "$work/year3.csv" --data "$data"
admin import-roster "$work/year3.csv" --passwords "$work/new.csv" --json "$work/import.json"
[ "$(stat -c %a "$work/new.csv")" = 600 ] || fail "the passwords are not for their owner only"
[ "$(wc -l <"$work/new.csv")" = 149 ] || fail "not one password for each of 148"
tail -n +2 "$work/new.csv" | tr -d '\r' | sed 's/.*,//' >>"$secrets"
! grep -q "$(tail -n1 "$work/new.csv" | tr -d '\r' | sed 's/.*,//')" "$work/import.json" || fail "a password in the outcome"
admin import-roster "$work/year3.csv" --json "$work/again.json"
[ "$(json_of "$work/again.json" unchanged)" = 148 ] || fail "importing twice changed something"
admin list-cohorts
[ "$(admin list-people --cohort "Year 3" --role student | wc -l)" = 144 ] || fail "not 144 students in the cohort"
found=$(expect 200 head GET '/api/v1/people?role=student&limit=200')
[ "$(member "$found" .people.length)" = 144 ] || fail "the page does not list 144 students"

step "a student signs in for the first time"
once=$(grep '^s007,' "$work/new.csv" | tr -d '\r' | sed 's/.*,//')
expect 200 s007 POST /api/v1/session "{\"login\":\"s007\",\"password\":\"$once\"}" >/dev/null
expect 403 s007 GET /api/v1/exercises
keep_secret "what s007 chose"
expect 200 s007 POST /api/v1/session/password "{\"old_password\":\"$once\",\"new_password\":\"what s007 chose\"}" >/dev/null
expect 200 s007 GET /api/v1/exercises >/dev/null
teacher=$(grep '^teacher1,' "$work/new.csv" | tr -d '\r' | sed 's/.*,//')
expect 200 teacher1 POST /api/v1/session "{\"login\":\"teacher1\",\"password\":\"$teacher\"}" >/dev/null
expect 200 teacher1 POST /api/v1/session/password "{\"old_password\":\"$teacher\",\"new_password\":\"what teacher1 chose\"}" >/dev/null

step "three stations"
for n in 1 2; do
  code=$(admin enrol-code)
  keep_secret "${code%@*}"
  "$bin/enamel-station" enrol --data "$work/station$n" --server "127.0.0.1:$((port + 1))" --code "$code" --name "Bench $n"
done
made=$(expect 201 head POST /api/v1/enrolment-codes '{"minutes":10}')
code=$(member "$made" .code)
keep_secret "${code%@*}"
"$bin/enamel-station" enrol --data "$work/station3" --server "127.0.0.1:$((port + 1))" --code "$code" --name "Bench 3"
expect_failure "a code that was used" "used or expired" \
  "$bin/enamel-station" enrol --data "$work/station4" --server "127.0.0.1:$((port + 1))" --code "$code" --name "Bench 4"

step "a room of stations, enrolled from one table"
printf 'Room 1\nRoom 2, left\n' >"$work/room"
printf 'Room 1\nroom  1\n' >"$work/twice"
expect_failure "two stations of one name" "line 2" "$bin/enamel-server" admin enrol-code --data "$data" --names "$work/twice"
admin enrol-code --names - <"$work/room" >"$work/codes.csv"
expect_failure "a station without a row" "no station named" \
  "$bin/enamel-station" enrol --data "$work/room3" --server "127.0.0.1:$((port + 1))" --codes "$work/codes.csv" --name "Room 3"
"$bin/enamel-station" enrol --data "$work/room1" --server "127.0.0.1:$((port + 1))" --codes "$work/codes.csv" --name "Room 1"
"$bin/enamel-station" enrol --data "$work/room2" --server "127.0.0.1:$((port + 1))" --codes - --name "Room 2, left" <"$work/codes.csv"
admin revoke-station --station "Bench 3"
admin list-stations

step "a device profile, checked"
admin put-profile "$root/schemas/golden/scene_profile_phantom_desktop.json" --check
sed 's/"value": 2500/"value": 25000/' "$root/schemas/golden/scene_profile_phantom_desktop.json" >"$work/stiff.json"
expect_failure "a profile that is not passive" "FAIL Passivity limit" \
  "$bin/enamel-server" admin put-profile "$work/stiff.json" --data "$data"
admin put-profile "$root/schemas/golden/scene_profile_phantom_desktop.json"
admin put-profile omega3
expect_failure "a profile that nobody made" "there are omega3, phantom_desktop" \
  "$bin/enamel-server" admin put-profile omega4 --data "$data"
admin add-calibration "$root/schemas/golden/scene_calibration.json"
admin list-calibrations --profile phantom_desktop

step "an exercise, assigned to the cohort, and done once"
admin publish-exercise --scene builtin:molar --name class-1 --voxel-um 100 --cohort "Year 3"
exercise=$(admin list-exercises | awk '/class-1/ { for (i = 1; i <= NF; ++i) if ($i ~ /^class-1/) { print $i; exit } }')
[ -n "$exercise" ] || { admin list-exercises; fail "no class I exercise is listed"; }
admin list-assignments
ENAMEL_PASSWORD="what s007 chose" "$bin/enamel-station" run --data "$work/station1" --server "127.0.0.1:$((port + 1))" \
  --exercise "$exercise" --profile phantom_desktop --user s007 --operator student --lockstep --quiet --json "$work/attempt.json"
attempt=$(json_of "$work/attempt.json" attempt_id)
expect_failure "a revoked station" "enrol" env ENAMEL_PASSWORD="what s007 chose" "$bin/enamel-station" run \
  --data "$work/station3" --server "127.0.0.1:$((port + 1))" --exercise "$exercise" --profile phantom_desktop --user s007 --lockstep --quiet

step "backup while it serves, restore into an empty folder, verify"
"$bin/enamel-server" backup "$work/backup" --data "$data" --json "$work/backup.json"
expect 200 head GET '/api/v1/audit?action=person.&limit=5' >"$work/audit.json"
expect 200 head GET '/api/v1/audit?limit=1000' >>"$work/audit.json"
cp "$work/server.log" "$work/first.log"
stop_server
cat "$work/server.log" >>"$work/first.log"
"$bin/enamel-server" restore "$work/backup" --data "$work/restored"
"$bin/enamel-server" verify --data "$work/restored"
start_server "$work/restored" "$port" --log-level debug
data=$work/restored
[ "$(admin list-people --cohort "Year 3" --role student | wc -l)" = 144 ] || fail "the restored cohort is not the one"
admin list-attempts | grep "$attempt"
expect 401 s007 GET /api/v1/session >/dev/null  # a restore ends all sessions
expect 200 s007 POST /api/v1/session '{"login":"s007","password":"what s007 chose"}' >/dev/null
expect 200 s007 GET "/api/v1/attempts/$attempt" >/dev/null
stop_server

step "nothing that is secret in the log"
for text in "$work/first.log" "$work/server.log" "$work/audit.json"; do
  [ -s "$text" ] || fail "$text is empty"
  ! grep -F -f "$secrets" "$text" || fail "a secret stands in $(basename "$text")"
done
grep -q "session" "$work/audit.json" || fail "the audit trail was not looked at"
echo "ok: $(wc -l <"$secrets") secrets looked for, none found"
