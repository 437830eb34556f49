#!/usr/bin/env bash
# An instructor says something at the chair of an attempt that is being made: the station prints it, once; its window shows it
# over the tooth until it is put away; the page's interface says that it was shown; it stays on the attempt.
# ENAMEL_PICTURES=FOLDER keeps the pictures.
. "$(dirname "$0")/support.sh"
pictures=${ENAMEL_PICTURES:-$work/pictures}
mkdir -p "$pictures"
station="$work/station"
export LC_ALL=C.UTF-8  # it reads English

"$bin/enamel-server" init --data "$work/server" >/dev/null
"$bin/enamel-server" seed-demo --data "$work/server" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
port=$(free_ports)
start_server "$work/server" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name "Chair 7" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$work/server")" >/dev/null
say() { node "$root/tests/integration/say.mjs" "$port" instructor enamel-demo-instructor "$@"; }

echo "== without a window"
stop='Stop: the mesial wall is thin. 请停一下。'
ENAMEL_PASSWORD=enamel-demo-student1 "$bin/enamel-station" run --data "$station" --profile phantom_desktop --quiet \
  --exercise "$exercise" --user student1 --operator student >"$work/run.log" 2>&1 &
runner=$!
pids+=("$runner")
say "$stop" "Now go on." | tee "$work/said.json"
kill -TERM "$runner"
rc=0
wait "$runner" || rc=$?
[ $rc -eq 3 ] || { cat "$work/run.log"; fail "the attempt was left with exit code $rc"; }
"$bin/enamel-station" spool close last --data "$station" >/dev/null
[ "$(grep -c "says: $stop\$" "$work/run.log")" -eq 1 ] || { cat "$work/run.log"; fail "it was not printed once"; }
grep -q "says: Now go on.\$" "$work/run.log" || { cat "$work/run.log"; fail "the second was not printed"; }
node -e '
  const { kept } = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  if (kept.length !== 2 || kept[0].text !== process.argv[2] || !(kept[0].tick > 0)) { console.error(kept); process.exit(1); }
' "$work/said.json" "$stop" || fail "it is not kept with its moment"
echo "ok: printed once, shown, kept"

echo "== at the window"
start_display
cat >"$work/chair.txt" <<EOF
page sign-in
type student1
key Tab
type enamel-demo-student1
key Enter
page exercises
key Enter
page exercise
see Bur:
click Start
page running
see 请停一下
frames 3
picture $pictures/remark.png
until $work/second
see x x
frames 3
picture $pictures/remark-long.png
until $work/third
key R
frames 3
picture $pictures/remark-away.png
key Escape
page paused
click Give up
page give-up
click Give up
page result
quit
EOF
timeout 300 "$bin/enamel-station" open --data "$station" --window 1280x720 --no-sound --simulated --script "$work/chair.txt" &
window=$!
pids+=("$window")
say "$stop" || fail "the window did not show it"
touch "$work/second"
# What waits comes 10 s after the first at the latest, which nobody has put away.
say "$(printf 'x %.0s' $(seq 249))" >/dev/null || fail "what waited was not shown"
touch "$work/third"
wait "$window" || { tail -n 20 "$work/server.log"; fail "the script did not get through"; }
[ -s "$pictures/remark-away.png" ] || fail "no picture"
stop_server
echo "a remark is read at the chair, once, and kept"
