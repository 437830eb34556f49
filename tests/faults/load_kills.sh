#!/usr/bin/env bash
# load_kills.sh [KILLS [STATIONS]]: STATIONS stations (50) stream at 1 kHz while their server is killed (kill -9)
# KILLS times (3, or 20 with ENAMEL_FULL=1) at random moments, one in three seconds, cables are pulled, chunks
# repeated and sent before their turn, and peers that mean no good come and go. Every tick the stations know to be
# committed is compared with the store byte by byte, then the folder with itself (verify).
#   tests/faults/load_kills.sh 200      the benchmark; about ten minutes
. "$(dirname "$0")/../integration/support.sh"
kills=${1:-}
[ -n "$kills" ] || { [ "${ENAMEL_FULL:-}" = 1 ] && kills=20 || kills=3; }
stations=${2:-50}
minutes=$(awk -v k="$kills" 'BEGIN { m = k * 0.05; print m < 0.15 ? 0.15 : m }')
"$bin/enamel-loadgen" --stations "$stations" --minutes "$minutes" --loop-seconds 5 --kills "$kills" --cuts "$((2 * kills))" \
  --repeated 0.05 --disordered 0.05 --hostile 10 --data "$work/server" --json "$work/load.json" 2>"$work/load.log" ||
  { tail -n 20 "$work/load.log"; fail "not everything that was committed is there once"; }
"$bin/enamel-server" verify --data "$work/server" >"$work/verify" 2>&1 || { cat "$work/verify"; fail "the server's data does not agree with itself"; }
field() { grep -o "\"$1\":[^,}]*" "$work/load.json" | cut -d: -f2; }
echo "$(field kills) kills: $(field ticks_committed) ticks committed," \
  "$(field ticks_lost) lost, $(field ticks_doubled) doubled;" \
  "longest restart $(printf %.2f "$(field restart_max_s)") s; load average $(cut -d' ' -f1 /proc/loadavg)"
tail -n 1 "$work/verify"
