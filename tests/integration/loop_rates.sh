#!/usr/bin/env bash
# One exercise on one device at several loop rates, from the first tick to the score: recorded at the device's rate,
# uploaded, verified and replayed to the bit by the server and by the core alone, scored about as at 1 kHz.
#   loop_rates.sh [RATE_HZ ...]      (default: 4000; RATE_HZ of 2000 and 8000 are for looking)
. "$(dirname "$0")/support.sh"
data=$work/server station=$work/station
port=$(free_ports)
rates=("$@")
[ ${#rates[@]} -gt 0 ] || rates=(4000)
export ENAMEL_PASSWORD=enamel-demo-instructor
server_cli() { "$bin/enamel-server" "$@"; }
station_cli() { "$bin/enamel-station" "$@"; }

server_cli init --data "$data" >/dev/null
server_cli seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
station_cli enrol --data "$station" --server "127.0.0.1:$((port + 1))" --code "$(server_cli admin enrol-code --data "$data")" --name rates

# cut EXERCISE PROFILE OPERATOR OUT [options]: an attempt, scored; its facts in OUT, its report in OUT.report.
cut() {
  local exercise=$1 profile=$2 operator=$3 out=$4
  shift 4
  station_cli run --data "$station" --lockstep --quiet --exercise "$exercise" --profile "$profile" --user instructor \
    --operator "$operator" --json "$out" "$@" >/dev/null
  server_cli report --data "$data" --attempt "$(json_of "$out" attempt_id)" --wait 600 --json "$out.report" >/dev/null
}
# Reference and attempt; prints rate, seconds, score.
pair() {
  local name=$1 exercise=$2 profile=$3
  cut "$exercise" "$profile" dentist "$work/$name.reference" --as-reference
  server_cli admin mark-reference --data "$data" --attempt "$(json_of "$work/$name.reference" attempt_id)" --dentist "Simulated dentist" \
    --consent >/dev/null
  cut "$exercise" "$profile" student "$work/$name"
  [ "$(json_of "$work/$name.report" witness_ok)" = true ] || fail "$name: the server's replay differs from what was felt"
  [ "$(json_of "$work/$name" ticks)" = "$(json_of "$work/$name.report" ticks)" ] || fail "$name: the server has other ticks than were recorded"
  [ "$(json_of "$work/$name" gap_ticks)" = 0 ] || fail "$name: gaps in an attempt that nothing disturbed"
  local attempt volume blob
  attempt=$(json_of "$work/$name" attempt_id)
  station_cli spool export --data "$station" "$attempt" --out "$work/$name.trace" >/dev/null
  for blob in "$station"/blobs/*; do
    if [ "$(head -c 4 "$blob" | tr -d '\0')" = ENTV ]; then volume=$blob; fi
  done
  if [ -x "$bin/core_replay" ]; then
    "$bin/core_replay" replay "$work/$name.trace" "$volume" | grep -q '^witness_ok 1' || fail "$name: the core alone does not replay it"
  fi
  echo "$name: $(json_of "$work/$name" ticks) ticks, score $(json_of "$work/$name.report" score)"
}

pair at_1000 "$exercise" phantom_desktop
# The documents as the station keeps them, with another rate.
document() { grep -l "\"$1\"" "$station"/blobs/* | head -n 1; }
for rate in "${rates[@]}"; do
  node -e '
    const fs = require("fs");
    const [exercise, profile, rate, out] = process.argv.slice(1);
    const e = JSON.parse(fs.readFileSync(exercise, "utf8"));
    e.name = `${e.name}-${rate}`; e.rate_hz = Number(rate);
    fs.writeFileSync(`${out}/exercise_${rate}.json`, JSON.stringify(e));
    const p = JSON.parse(fs.readFileSync(profile, "utf8"));
    p.name = `fast_${rate}`; p.rate_hz = { value: Number(rate), source: "chosen" };
    fs.writeFileSync(`${out}/profile_${rate}.json`, JSON.stringify(p));
  ' "$(document rubric)" "$(document workspace_radius_um)" "$rate" "$work"
  server_cli admin put-profile --data "$data" "$work/profile_$rate.json" >/dev/null
  server_cli admin publish-exercise --data "$data" --document "$work/exercise_$rate.json" >/dev/null
  pair "at_$rate" "$(node -p "JSON.parse(require('fs').readFileSync('$work/exercise_$rate.json')).name")" "fast_$rate"
  # As much time as at 1 kHz within a tenth, and a score within five of a hundred: the hand is a person's, its tremor differs.
  node -e '
    const read = (name) => JSON.parse(require("fs").readFileSync(`${process.argv[1]}/${name}`, "utf8"));
    const rate = Number(process.argv[2]);
    const [slow, fast] = [read("at_1000"), read(`at_${rate}`)];
    const [s, f] = [read("at_1000.report").score, read(`at_${rate}.report`).score];
    const seconds = fast.ticks / rate / (slow.ticks / 1000);
    const wrong = Math.abs(seconds - 1) > 0.1 ? `took ${seconds.toFixed(2)} times as long` : Math.abs(s - f) > 5 ? `scored ${f}, at 1 kHz ${s}` : "";
    if (wrong) { console.error(`${rate} Hz: ${wrong}`); process.exit(1); }
  ' "$work" "$rate" || fail "another attempt at $rate Hz than at 1 kHz"
done
stop_server
echo "ok: ${rates[*]} Hz from the first tick to the score"
