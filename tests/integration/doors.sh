#!/usr/bin/env bash
# doors.sh [--json FILE]: one student asks for a large surface on 80 connections, then reads nothing on 60, and three
# addresses guess passwords: others' requests and owners' sign-ins are not refused meanwhile. ENAMEL_FULL=1: a surface of
# 15 MB, for a minute.
. "$(dirname "$0")/support.sh"
json=
[ "${1:-}" != --json ] || json=$(realpath -m "${2:?--json expects a file}")
export ENAMEL_PASSWORD
data=$work/server station=$work/station
port=$(free_ports)
voxel=150 seconds=4
[ "${ENAMEL_FULL:-}" != 1 ] || { voxel=60; seconds=30; }
"$bin/enamel-server" init --data "$data" >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um $voxel --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$("$bin/enamel-server" admin enrol-code --data "$data")" --name doors >/dev/null
# cut LOGIN OPERATOR [OPTION...]: makes an attempt and waits for its score; prints its id.
cut() {
  ENAMEL_PASSWORD=enamel-demo-$1
  "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" --user "$1" --operator "$2" \
    --json "$work/cut.json" "${@:3}" >"$work/run.log" 2>&1 || { cat "$work/run.log" >&2; fail "$1's attempt"; }
  json_of "$work/cut.json" attempt_id
  "$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/cut.json" attempt_id)" --wait 600 >/dev/null
}
reference=$(cut instructor dentist --as-reference)
"$bin/enamel-server" admin mark-reference --data "$data" --attempt "$reference" --dentist "Simulated dentist" --consent >/dev/null
attempt=$(cut student1 student)
"$bin/enamel-server" admin release --data "$data" --attempt "$attempt" >/dev/null 2>&1 || true
for owner in anna ben; do
  "$bin/enamel-server" admin add-person --data "$data" --login $owner --name "$owner" --role student --password-stdin >/dev/null <<<"a quite unlikely password 7"
done
node "$root/tests/integration/doors.mjs" "$port" "$server" "$attempt" $seconds "$json" || { tail -n 20 "$work/server.log"; exit 1; }
stop_server
