#!/usr/bin/env bash
# Each refusal as a user meets it: a message that says what is wrong, an exit code that is not 0, nothing lost.
. "$(dirname "$0")/support.sh"
server=""
port=$(free_ports)
data=$work/server station=$work/station
enamel_server=$bin/enamel-server enamel_station=$bin/enamel-station

"$enamel_server" seed-demo --data "$data" --json "$work/seed" >/dev/null
exercise=$(node -p "JSON.parse(require('fs').readFileSync('$work/seed','utf8')).exercise")
start_server "$data" "$port"

expect_failure "port in use" "in use" "$enamel_server" serve --data "$work/other" --http "127.0.0.1:$port" --stations 127.0.0.1:0
expect_failure "data folder of a running server" "running|lock|another" "$enamel_server" serve --data "$data" --http 127.0.0.1:0 --stations 127.0.0.1:0
expect_failure "page beyond loopback without TLS" "loopback|TLS|certificate" "$enamel_server" serve --data "$work/other2" --http 0.0.0.0:0 --stations 127.0.0.1:0
touch "$work/file"
expect_failure "data folder that is a file" "folder|directory" "$enamel_server" serve --data "$work/file/x" --http 127.0.0.1:0 --stations 127.0.0.1:0
expect_failure "attempt that does not exist" "not|no attempt" "$enamel_server" report --data "$data" --attempt 01234567-89ab-7cde-8f01-23456789abcd
expect_failure "attempt id that is none" "expected" "$enamel_server" report --data "$data" --attempt banana

expect_failure "enrolment code that is none" "code" "$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code nonsense
code=$("$enamel_server" admin enrol-code --data "$data")
wrong=${code%@*}@$(printf '0%.0s' $(seq 64))
expect_failure "server with another identity" "fingerprint|identity" "$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$wrong"
"$enamel_station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$code" --name test
expect_failure "enrolment code used twice" "code" "$enamel_station" enrol --data "$work/station2" --server "127.0.0.1:$((port + 1))" --code "$code"

run=("$enamel_station" run --data "$station" --profile phantom_desktop --lockstep --quiet)
export ENAMEL_PASSWORD=wrong
expect_failure "wrong password" "password|sign" "${run[@]}" --exercise "$exercise" --user student1
expect_failure "unknown login reads the same" "password|sign" "${run[@]}" --exercise "$exercise" --user nobody
export ENAMEL_PASSWORD=enamel-demo-student1
expect_failure "unknown exercise" "exercise" "${run[@]}" --exercise nothing --user student1
expect_failure "unknown profile" "profile" "$enamel_station" run --data "$station" --lockstep --quiet --exercise "$exercise" --profile nothing --user student1
expect_failure "student asking for a reference cut" "reference|may not|forbidden|instructor" "${run[@]}" --exercise "$exercise" --user student1 --as-reference

printf 'solid nothing\nendsolid nothing\n' >"$work/empty.stl"
expect_failure "mesh without triangles" "triangle|empty|no " "$enamel_station" import "$work/empty.stl" --unit mm --out "$work/scene"
printf 'solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 9 0\nendloop\nendfacet\nendsolid one\n' >"$work/open.stl"
expect_failure "mesh that is no solid" "solid|open|closed|triangle" "$enamel_station" import "$work/open.stl" --unit mm --out "$work/scene"
[ ! -e "$work/scene/scene.json" ] || fail "a refused mesh left a scene behind"
expect_failure "mesh that is not there" "no mesh file|open" "$enamel_station" import "$work/none.stl" --unit mm --out "$work/scene"

# The server goes away in the middle: the station keeps recording, says so, and uploads later.
"${run[@]}" --exercise "$exercise" --user student1 --operator student --json "$work/cut.json" >"$work/cut.log" 2>&1 &
runner=$!
pids+=("$runner")
for _ in $(seq 600); do
  "$enamel_station" spool list --data "$station" 2>/dev/null | grep -qE ' [1-9][0-9]* of ' && break
  kill -0 "$runner" 2>/dev/null || break
  sleep 0.05
done
kill -KILL "$server"
wait "$server" 2>/dev/null || true
rc=0
wait "$runner" || rc=$?
[ $rc -eq 3 ] || [ $rc -eq 0 ] || { cat "$work/cut.log"; fail "recording without a server ended with exit code $rc"; }
if [ $rc -eq 3 ]; then
  echo "ok: server killed mid-attempt: $(grep -iE -m1 'upload|server' "$work/cut.log" | cut -c1-160)"
  expect_failure "upload while the server is away" "refused|reach|connect" "$enamel_station" upload --data "$station"
fi
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
expect_failure "database of a newer version" "newer|version" "$enamel_server" serve --data "$data" --http 127.0.0.1:0 --stations 127.0.0.1:0
echo "all refusals in order"
