#!/usr/bin/env bash
# Every exercise with every way to hold the handpiece: a simulated hand, and each emulated device through the driver that it
# would have. Each attempt is begun, cuts something, is handed in and gets its score. Prints a
# table: exercise, device, removed mm³, points, faults, ticks in gaps.
#   every_device.sh [EXERCISE ...] [-- DEVICE ...]      without names: all exercises, with ENAMEL_FULL=1 only
. "$(dirname "$0")/support.sh"
[ $# -gt 0 ] || [ "${ENAMEL_FULL:-}" = 1 ] || { echo "skipped: ENAMEL_FULL=1 runs it"; exit 77; }
data=$work/server station=$work/station
exercises=() devices=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do exercises+=("$1"); shift; done
[ $# -eq 0 ] || { shift; devices=("$@"); }
[ ${#devices[@]} -gt 0 ] || devices=(simulated hid spacemouse inverse3 woodenhaptics polhem polhem_serial falcon dhd openhaptics)

"$bin/enamel-server" init --data "$data" >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 100 >/dev/null
for scene in molar premolar incisor molar-caries molar-class-2 molar-buccal incisor-labial block; do
  "$bin/enamel-server" admin publish-exercise --data "$data" --scene "builtin:$scene" --voxel-um 100 --cohort "Demo cohort" >/dev/null
done
for profile in omega3 phantom_desktop falcon inverse3 pointer polhem_v1 polhem_v3 woodenhaptics_v2015; do
  "$bin/enamel-server" admin put-profile --data "$data" "$profile" >/dev/null
done
# Practice and graded work of an exercise are the same tooth, target and rubric.
[ ${#exercises[@]} -gt 0 ] || mapfile -t exercises < <("$bin/enamel-server" admin list-exercises --data "$data" |
  awk '$4 == "published" && $5 == "practice" { print $6 }')
port=$(free_ports)
start_server "$data" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name "Chair 7" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" >/dev/null
export ENAMEL_PASSWORD

# attempt DEVICE LOGIN EXERCISE: its facts in $work/facts.
attempt() {
  rm -f "$work/facts"
  ENAMEL_PASSWORD=enamel-demo-$2
  if [ "$1" = simulated ]; then
    "$bin/enamel-station" run --data "$station" --lockstep --quiet --user "$2" --operator "${4:-student}" --exercise "$3" \
      --profile phantom_desktop --json "$work/facts" "${@:5}"
  else
    timeout $((120 * patience)) "$bin/emulated_attempt" "$1" "$station" "$2" "$3" "$work/facts"
  fi >"$work/attempt.log" 2>&1
}
# row DEVICE EXERCISE: shows the line of the table; prints what is wrong with the attempt.
row() {
  node -e '
    const fs = require("fs"), [factsFile, reportFile, device, exercise] = process.argv.slice(1);
    const facts = JSON.parse(fs.readFileSync(factsFile)), report = JSON.parse(fs.readFileSync(reportFile));
    const removed = Object.values(facts.removed_mm3).reduce((a, b) => a + b, 0), of = (text, width) => String(text).padStart(width);
    console.error(exercise.padEnd(36), device.padEnd(14), of(removed.toFixed(2), 9), of(report.score.toFixed(0), 7), of(facts.faults, 7),
      of(facts.gap_ticks, 6));
    if (!(removed > 0)) console.log("nothing was cut");
    else if (!report.witness_ok) console.log("the replay differs from what was felt");
  ' "$work/facts" "$work/report" "$1" "$2" 2>&3
}
exec 3>&1
printf '%-36s %-14s %9s %7s %7s %6s\n' exercise device 'mm³' points faults gaps
bad=0
for exercise in "${exercises[@]}"; do
  attempt simulated instructor "$exercise" dentist --as-reference || { cat "$work/attempt.log"; fail "no reference of $exercise"; }
  reference=$(json_of "$work/facts" attempt_id)
  "$bin/enamel-server" report --data "$data" --attempt "$reference" --wait $((120 * patience)) >/dev/null || true
  "$bin/enamel-server" admin mark-reference --data "$data" --attempt "$reference" --dentist "Simulated dentist" --consent \
    >"$work/mark.log" 2>&1 || { cat "$work/mark.log"; fail "the cut is no reference of $exercise"; }
  for device in "${devices[@]}"; do
    if attempt "$device" student1 "$exercise" &&
      "$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/facts" attempt_id)" --wait $((120 * patience)) \
        --json "$work/report" >"$work/attempt.log" 2>&1; then
      problem=$(row "$device" "$exercise")
    else
      problem=$(tail -n 1 "$work/attempt.log")
    fi
    [ -z "$problem" ] || { printf '%-36s %-14s %s\n' "$exercise" "$device" "FAILED: $problem"; bad=$((bad + 1)); }
  done
done
[ $bad -eq 0 ] || fail "$bad of $((${#exercises[@]} * ${#devices[@]})) attempts"
echo "ok: ${#exercises[@]} exercises on ${#devices[@]} devices"
