#!/usr/bin/env bash
# Recordings that a server lost, cut short or changed come back from the chairs that still have them, as they were.
#   healing.sh SCHOOL    what tests/e2e/school/make.mjs made
. "$(dirname "$0")/support.sh"
school=$1
[ -f "$school/school.json" ] || { echo "skipped: no school in $school (node tests/e2e/school/make.mjs makes one)"; exit 77; }
cp -r "$school/." "$work/school"
data=$work/school/data

damaged=0
while read -r name; do
  blob=$data/blobs/${name:0:2}/$name
  case $((damaged++ % 3)) in
    0) rm "$blob" ;;
    1) truncate -s 1000 "$blob" ;;
    2) dd if=/dev/zero of="$blob" bs=16 seek=30 count=1 conv=notrunc status=none ;;
  esac
done < <(python3 -c '
import sqlite3, sys
for (name,) in sqlite3.connect(sys.argv[1]).execute("SELECT trace_blob FROM attempts WHERE trace_blob IS NOT NULL ORDER BY id"):
    print(name.hex())' "$data/enamel.db")
[ "$damaged" -gt 20 ] || fail "expected the recordings of a school, found $damaged"
expect_failure "a damaged store" "$damaged things do not agree" "$bin/enamel-server" verify --data "$data"

port=$(free_ports)
start_server "$data" "$port"
for chair in "Chair 1" "Chair 2"; do
  "$bin/enamel-station" upload --data "$work/school/$chair" --server "127.0.0.1:$((port + 1))" >"$work/out" ||
    { cat "$work/out"; fail "$chair could not send its recordings again"; }
done
stop_server
"$bin/enamel-server" verify --data "$data" >"$work/out" || { cat "$work/out"; fail "not all came back"; }
grep -q "everything agrees" "$work/out" || fail "verify said: $(cat "$work/out")"
echo "ok: $damaged recordings came back"
