#!/usr/bin/env bash
# A prepared tooth becomes an exercise's target: from a scan, and from a reference. The cut that is made into a scan here
# is the demo's own; what is checked is that it comes back as the target, is graded without a reference, and that the
# hand that follows it is near it.
. "$(dirname "$0")/support.sh"
data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor
server_cli() { "$bin/enamel-server" "$@"; }
station_cli() { "$bin/enamel-station" "$@"; }
# attempt EXERCISE OPERATOR FILE [options]: an instructor's attempt, scored; its report is FILE.
attempt() {
  local exercise=$1 operator=$2 file=$3
  shift 3
  station_cli run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" \
    --user instructor --operator "$operator" --json "$work/cut.json" "$@" >/dev/null
  server_cli report --data "$data" --attempt "$(json_of "$work/cut.json" attempt_id)" --wait 600 --json "$file" >/dev/null
}
# published LOG: the exercise that publish-exercise and target-from-reference name.
published() { sed -nE 's/^exercise "([a-z0-9-]+)".*/\1/p' "$1" | head -n 1; }

server_cli init --data "$data" >/dev/null
server_cli seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
station_cli enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$(server_cli admin enrol-code --data "$data")" --name target
attempt "$exercise" dentist "$work/reference.json" --as-reference
reference=$(json_of "$work/cut.json" attempt_id)

echo "== from a scan"
station_cli spool export --data "$station" "$reference" --out "$work/cut.entr" >/dev/null
station_cli replay --data "$station" "$work/cut.entr" --surface "$work/scan.ply" >/dev/null
station_cli target "$work/scan.ply" --unit mm --scene builtin:molar --voxel-um 100 --out "$work/target" >"$work/target.log" ||
  { cat "$work/target.log"; fail "the scan was not taken"; }
grep -E 'agrees|preparation' "$work/target.log"
expect_failure "a scan in another unit" "mm" "$bin/enamel-station" target "$work/scan.ply" --unit inch --scene builtin:molar --voxel-um 100 --out "$work/inch"
expect_failure "another tooth" "does not fit|mirror" "$bin/enamel-station" target "$work/scan.ply" --unit mm --scene builtin:premolar --voxel-um 100 --out "$work/other"
expect_failure "published on another tooth" "another tooth" "$bin/enamel-server" admin publish-exercise --data "$data" --scene builtin:premolar --voxel-um 100 --prepared "$work/target"
server_cli admin publish-exercise --data "$data" --scene builtin:molar --voxel-um 100 --prepared "$work/target" | tee "$work/published.log"
! grep -q "no reference" "$work/published.log" || fail "an exercise with a prepared tooth waits for a reference"
attempt "$(published "$work/published.log")" dentist "$work/scan.json"
score=$(json_of "$work/scan.json" score)
node -e 'process.exit(Number(process.argv[1]) > 70 ? 0 : 1)' "$score" || { cat "$work/scan.json"; fail "the dentist has $score points after the scan"; }
echo "ok: graded without a reference, $score points"

echo "== from a reference"
server_cli admin mark-reference --data "$data" --attempt "$reference" --dentist "Simulated dentist" --consent >/dev/null
name=$(server_cli admin list-exercises --data "$data" --state published | grep -oE 'class-1-[a-z0-9-]+' | head -n 1)
server_cli admin target-from-reference --data "$data" --exercise "$name" | tee "$work/next.log"
grep -q "version 2" "$work/next.log" || fail "no next version"
server_cli admin assign-exercise --data "$data" --exercise "$name" --hands any >/dev/null
attempt "$(published "$work/next.log")" student-deep-mesial "$work/deep.json"
node -e '
  const report = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  const wall = report.mistakes.find(({ kind, place }) => kind === "over_extended" && place === "wall_mesial");
  console.log(`mesial wall ${wall?.size} mm too far`);
  process.exit(wall && Math.abs(wall.size - 0.3) < 0.06 ? 0 : 1);' "$work/deep.json" || { cat "$work/deep.json"; fail "the mesial wall is not found 0.3 mm over-extended"; }
server_cli verify --data "$data" >"$work/verify.log" || { cat "$work/verify.log"; fail "what is stored does not agree"; }
echo "ok: the reference's tooth is the target of version 2, and verify agrees"
