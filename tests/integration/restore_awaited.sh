#!/usr/bin/env bash
# A backup is older than the lost data folder: a person, a station and an exercise came after it, and recordings of
# each. As server/README.md tells: restore, see what is awaited, bring it back, and everything is sealed and scored.
# Then a person is erased beside the running server: the login is in no file of a backup made after, key and attempts
# are gone.
. "$(dirname "$0")/support.sh"
port=$(free_ports)
data=$work/data
link=127.0.0.1:$((port + 1))
admin() { "$bin/enamel-server" admin "$@" --data "$data"; }
step() { printf '\n==> %s\n' "$*"; }
password='a long enough password'
latecomer=late-$RANDOM-$RANDOM  # a login that occurs nowhere else
named() { grep -rqaF -- "$latecomer" "$1"; }  # in a file below the folder
add() { printf '%s\n' "$password" | admin add-person --password-stdin "$@"; }
enrol() { "$bin/enamel-station" enrol --data "$work/$1" --server "$link" --code "$(admin enrol-code)" "${@:2}"; }
publish() { admin publish-exercise --scene builtin:molar --name class-1 --voxel-um "$1"; }
upload() { "$bin/enamel-station" upload --data "$work/$1" --server "$link"; }
# attempt NAME STATION LOGIN OPERATOR [OPTION…]: at the newest version of the exercise, as fast as the machine can.
attempt() {
  ENAMEL_PASSWORD=$password "$bin/enamel-station" run --data "$work/$2" --server "$link" --exercise class-1-molar-46 \
    --profile phantom_desktop --user "$3" --operator "$4" --lockstep --quiet --json "$work/$1.json" "${@:5}"
}
id_of() { json_of "$work/$1.json" attempt_id; }
# reference NAME: by the instructor at station 1.
reference() {
  attempt "$1" station1 dentist dentist --as-reference
  wait_scored "$1"
  mark "$1"
}
mark() { admin mark-reference --attempt "$(id_of "$1")" --dentist "Simulated dentist" --consent; }
wait_scored() {
  local name
  for name in "$@"; do
    "$bin/enamel-server" report --data "$data" --attempt "$(id_of "$name")" --wait 120 >"$work/report" ||
      { cat "$work/report"; admin list-attempts; fail "$name is not scored"; }
  done
}

step "before the backup: a person, a station, an exercise"
start_server "$data" "$port"
add --login early --role student
add --login dentist --role instructor
enrol station1 --name "Bench 1"
publish 150
reference first_cut
"$bin/enamel-server" backup "$work/backup" --data "$data"

step "after it: one more of each, with a recording"
add --login "$latecomer" --role student
enrol station2 --name "Bench 2"
attempt late_person station1 "$latecomer" student
attempt late_station station2 early student
publish 160
reference second_cut
admin move-assignment --assignment "$(admin list-assignments | grep -v practice | cut -d ' ' -f 1)" >/dev/null
attempt late_exercise station1 early student
wait_scored late_person late_station late_exercise

step "the data folder is lost, the backup is restored: what the stations hold is awaited"
kill_server
"$bin/enamel-server" restore "$work/backup" --data "$work/restored" --keyring "$data/keyring"
data=$work/restored
start_server "$data" "$port"
upload station1 || true
expect_failure "a station that is newer than the backup" "enrol --again" \
  "$bin/enamel-station" upload --data "$work/station2" --server "$link"
admin list-awaited | tee "$work/awaited"
[ "$(grep -c '"person":' "$work/awaited")" = 1 ] || fail "not one person is awaited"
[ "$(grep -c '"exercise":' "$work/awaited")" = 2 ] || fail "not the exercise of two recordings is awaited"
person=$(sed -n 's/.*"person":"\([^"]*\)".*/\1/p' "$work/awaited")

step "brought back, as the list says"
add --login "$latecomer" --role student --id "$person"
publish 160
enrol station2 --again
upload station1
upload station2
wait_scored second_cut
mark second_cut
# A cut that becomes a reference is scored once more, beside itself.
wait_scored first_cut second_cut late_person late_station late_exercise
admin list-awaited | grep -q "nothing waits" || fail "something is still awaited"
[ "$(admin list-attempts | grep -c ' scored ')" = 5 ] || { admin list-attempts; fail "not the five attempts"; }
"$bin/enamel-server" verify --data "$data"

step "a person is erased beside the server; a backup made then is restored, and verified"
[ -e "$data/keyring/$person.key" ] || fail "keys are no longer kept where this looks"
named "$data" || fail "the name is not kept where this looks"
admin erase-person --login "$latecomer" --confirm "$latecomer"
"$bin/enamel-server" backup "$work/after" --data "$data"
for folder in "$data" "$work/after"; do ! named "$folder" || fail "the erased person's login is in $folder"; done
stop_server
"$bin/enamel-server" restore "$work/after" --data "$work/again"
"$bin/enamel-server" verify --data "$work/again"
data=$work/again
[ "$(admin list-attempts | grep -c ' scored ')" = 4 ] || { admin list-attempts; fail "not the attempts of who stays"; }
! named "$data" || fail "the erased person's login is in what was restored"
[ ! -e "$data/keyring/$person.key" ] || fail "the key of the erased person is there"
echo "ok: restored, awaited, brought back, erased"
