#!/usr/bin/env bash
# Each refusal as a user meets it: a message that says what is wrong, an exit code that is not 0, nothing lost.
. "$(dirname "$0")/support.sh"
server=""
port=$(free_ports)
data=$work/server station=$work/station
enamel_server=$bin/enamel-server enamel_station=$bin/enamel-station

"$enamel_server" init --data "$data" >/dev/null
"$enamel_server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(node -p "JSON.parse(require('fs').readFileSync('$work/seed','utf8')).exercise")
start_server "$data" "$port"

expect_failure "port in use" "in use; stop the program" "$enamel_server" serve --data "$work/other" --http "127.0.0.1:$port" --stations 127.0.0.1:0
expect_failure "data folder of a running server" "another enamel-server uses" "$enamel_server" serve --data "$data" --http 127.0.0.1:0 --stations 127.0.0.1:0
expect_failure "page beyond loopback without TLS" "expected TLS for 0.0.0.0" "$enamel_server" serve --data "$work/other2" --http 0.0.0.0:0 --stations 127.0.0.1:0
touch "$work/file"
expect_failure "data folder that is a file" "name a folder this user may write" "$enamel_server" serve --data "$work/file/x" --http 127.0.0.1:0 --stations 127.0.0.1:0
# As somebody who is not root, whom no permission stops.
mkdir -m 0755 "$work/locked"
chmod 0755 "$work"
as_user=()
[ "$(id -u)" -ne 0 ] || as_user=(setpriv --reuid 65534 --regid 65534 --clear-groups)
[ ${#as_user[@]} -gt 0 ] || chmod 0555 "$work/locked"
mkdir -m 0700 "$work/closed"
[ ${#as_user[@]} -gt 0 ] || chmod 0 "$work/closed"
may_run() { "${as_user[@]}" "$1" --version >/dev/null 2>&1 || "${as_user[@]}" "$1" --help >/dev/null 2>&1; }
if may_run "$enamel_server" && may_run "$enamel_station"; then
  expect_failure "data folder that may not be written" "name a folder this user may write" \
    "${as_user[@]}" "$enamel_server" serve --data "$work/locked/data" --http 127.0.0.1:0 --stations 127.0.0.1:0
  expect_failure "data folder that another user made" "name a folder this user may write" \
    "${as_user[@]}" "$enamel_server" serve --data "$work/closed" --http 127.0.0.1:0 --stations 127.0.0.1:0
  expect_failure "station folder that may not be written" "choose another with --data" \
    "${as_user[@]}" "$enamel_station" enrol --data "$work/locked/station" --server "127.0.0.1:$((port + 1))" --code "c@$(printf 'a%.0s' $(seq 64))"
  expect_failure "scene folder that may not be written" "name a place that this user may write" \
    "${as_user[@]}" "$enamel_station" import "$work/none.stl" --tooth 46 --unit mm --out "$work/locked/scene"
else
  echo "skipped: folders that may not be written: user 65534 cannot run the programs in $bin"
fi
expect_failure "facts into a folder that is not there" "name a place that this user may write" \
  "$enamel_station" simulate --json "$work/none/facts.json"
expect_failure "attempt that does not exist" "no attempt 01234567" "$enamel_server" report --data "$data" --attempt 01234567-89ab-7cde-8f01-23456789abcd
expect_failure "a failure where logs are JSON" '"level":"error","message":"expected an id like' env ENAMEL_LOG_FORMAT=json "$enamel_server" report --data "$data" --attempt banana
expect_failure "wrong usage where logs are JSON" '"level":"error","message":"' "$enamel_server" serve --log-format json --banana
expect_failure "attempt id that is none" "expected an id like" "$enamel_server" report --data "$data" --attempt banana

expect_failure "enrolment code that is none" "expected CODE@FINGERPRINT" "$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code nonsense
code=$("$enamel_server" admin enrol-code --data "$data")
wrong=${code%@*}@$(printf '0%.0s' $(seq 64))
expect_failure "server with another identity" "SHA-256 fingerprint" "$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$wrong"
"$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$code" --name test
for folder in "$station" "$work/server"; do
  [ "$(stat -c %a "$folder")" = 700 ] || fail "$folder holds keys and is open to others (mode $(stat -c %a "$folder"))"
done
expect_failure "enrolment code used twice" "unknown, used or expired" "$enamel_station" enrol --data "$work/station2" --server "127.0.0.1:$((port + 1))" --code "$code"

run=("$enamel_station" run --data "$station" --profile phantom_desktop --lockstep --quiet)
export ENAMEL_PASSWORD=wrong
expect_failure "wrong password" "login or password is wrong" "${run[@]}" --exercise "$exercise" --user student1
expect_failure "unknown login reads the same" "login or password is wrong" "${run[@]}" --exercise "$exercise" --user nobody
export ENAMEL_PASSWORD=enamel-demo-student1
expect_failure "unknown exercise" "no exercise .nothing." "${run[@]}" --exercise nothing --user student1
expect_failure "unknown profile" "no device profile .nothing." "$enamel_station" run --data "$station" --lockstep --quiet --exercise "$exercise" --profile nothing --user student1
expect_failure "student asking for a reference cut" "only instructors and admins record reference cuts" "${run[@]}" --exercise "$exercise" --user student1 --as-reference

expect_failure "window without a display" "display" env -u DISPLAY -u WAYLAND_DISPLAY "${run[@]}" --exercise "$exercise" --user student1 --window
expect_failure "attempt whose facts go nowhere" "name a place that this user may write" "${run[@]}" --exercise "$exercise" --user student1 --json "$work/none/cut.json"
"$enamel_server" admin list-attempts --data "$data" >"$work/list"
[ ! -s "$work/list" ] || { cat "$work/list"; fail "a refused attempt is left on the server"; }
[ "$(stat -c %a "$station/blobs")" = 700 ] || fail "the station's cache is open to others"

printf 'solid nothing\nendsolid nothing\n' >"$work/empty.stl"
expect_failure "mesh without triangles" "no triangles" "$enamel_station" import "$work/empty.stl" --tooth 46 --unit mm --out "$work/scene"
printf 'solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\nendsolid one\n' >"$work/open.stl"
expect_failure "mesh that is no solid" "this mesh is no solid" "$enamel_station" import "$work/open.stl" --tooth 46 --unit mm --out "$work/scene"
[ ! -e "$work/scene/scene.json" ] || fail "a refused mesh left a scene behind"
mkdir "$work/made" && echo '{}' >"$work/made/scene.json"
expect_failure "import over a scene" "nothing is overwritten" "$enamel_station" import "$work/open.stl" --tooth 46 --unit mm --out "$work/made"
expect_failure "mesh that is not there" "there is no mesh file" "$enamel_station" import "$work/none.stl" --tooth 46 --unit mm --out "$work/scene"

# The server goes away in the middle: the station keeps recording, says so, and uploads later.
# cut_without_server: false when the attempt was over before the server was gone.
cut_without_server() {
  "${run[@]}" --exercise "$exercise" --user student1 --operator student --json "$work/cut.json" >"$work/cut.log" 2>&1 &
  local runner=$! rc=0
  pids+=("$runner")
  for _ in $(seq 2400); do
    "$enamel_station" spool list --data "$station" | grep -qE 'unfinished .* [1-9][0-9]* of [0-9]+ chunks' && break
    kill -0 "$runner" 2>/dev/null || break
    sleep 0.05
  done
  kill -STOP "$runner" 2>/dev/null || true
  local halfway=no
  "$enamel_station" spool list --data "$station" | grep -q unfinished && halfway=yes
  [ $halfway = no ] || kill_server
  kill -CONT "$runner" 2>/dev/null || true
  wait "$runner" || rc=$?
  [ $halfway = yes ] || { [ $rc -eq 0 ] && return 1; cat "$work/cut.log"; fail "the attempt ended with exit code $rc"; }
  [ $rc -eq 3 ] || { cat "$work/cut.log"; fail "recording without a server ended with exit code $rc, expected 3"; }
}
cut_without_server || cut_without_server || fail "twice the attempt was over before the server could be stopped"
grep -q "recorded and safe" "$work/cut.log" || { cat "$work/cut.log"; fail "the station does not say that nothing is lost"; }
echo "ok: server killed mid-attempt: $(grep -m1 'recorded and safe' "$work/cut.log" | cut -c1-200)"
expect_failure "upload while the server is away" "127.0.0.1:$((port + 1))" "$enamel_station" upload --data "$station"
start_server "$data" "$port"
"$enamel_station" upload --data "$station"
attempt=$(node -p "JSON.parse(require('fs').readFileSync('$work/cut.json','utf8')).attempt_id")
ticks=$(node -p "JSON.parse(require('fs').readFileSync('$work/cut.json','utf8')).ticks")
"$enamel_server" admin list-attempts --data "$data" >"$work/list"
grep "$attempt" "$work/list" | grep -q "$ticks" || { cat "$work/list"; fail "not all of the $ticks ticks arrived"; }
echo "ok: all $ticks ticks are on the server after it came back"
stop_server

sqlite=$(find "$data" -name '*.sqlite' -o -name '*.db' | head -n 1)
node -e '
  // user_version is at offset 60 of the database header, big-endian.
  const fs = require("fs"), fd = fs.openSync(process.argv[1], "r+"), b = Buffer.alloc(4);
  b.writeUInt32BE(99999); fs.writeSync(fd, b, 0, 4, 60); fs.closeSync(fd);' "$sqlite"
expect_failure "database of a newer version" "newer enamel-server" "$enamel_server" serve --data "$data" --http 127.0.0.1:0 --stations 127.0.0.1:0
echo "all refusals in order"
