#!/usr/bin/env bash
# Records attempts with one build of the core and re-runs each with every build, and with the wide kernels
# switched off: all must say the same, and agree with the recorded witness. A difference is named to tick and
# brick. ENAMEL_FULL=1: 21 recordings, each bur shape three times, instead of 2.
set -euo pipefail
release=$1 builds=$2
others=()
for preset in core-clang-O0 core-clang-O3 core-gcc-O0; do
  [ -x "$builds/$preset/bin/core_replay" ] && others+=("$builds/$preset/bin/core_replay")
done
[ ${#others[@]} -gt 0 ] || echo "no other build of the core under $builds (./check makes one, ./check --full three): kernels only"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# agree SEED COMMAND...: the command's replay of the recording is what the recording build's was.
agree() {
  local seed=$1
  shift
  "$@" replay "$work/t" "$work/v" >"$work/b" || true
  cmp -s "$work/a" "$work/b" && return
  diff "$work/a" "$work/b" || true
  "$release" digest "$work/t" "$work/v" >"$work/da"
  "$@" digest "$work/t" "$work/v" >"$work/db"
  "$release" diff "$work/da" "$work/db" || true
  echo "seed $seed: $* disagrees"
  exit 1
}

count=2
[ "${ENAMEL_FULL:-0}" = 1 ] && count=21
for seed in $(seq "$count"); do
  "$release" record "$seed" "$work/t" "$work/v"
  "$release" replay "$work/t" "$work/v" >"$work/a"
  agree "$seed" env ENAMEL_SIMD=off "$release"
  for other in "${others[@]}"; do agree "$seed" "$other"; done
  grep -q '^removed enamel [1-9]' "$work/a" || { echo "seed $seed: the recording cut nothing"; exit 1; }
  echo "seed $seed: $(grep state_hash "$work/a") $(grep final_volume "$work/a" | cut -c1-30)"
done

# The names are right: a run in which one tick's input is another differs from that tick on, and the first
# brick that differs is named.
"$release" digest "$work/t" "$work/v" >"$work/da"
tick=$(awk 'NF > 2 && ++n == 40 { print $1; exit }' "$work/da")
"$release" digest "$work/t" "$work/v" "$tick" >"$work/db"
said=$("$release" diff "$work/da" "$work/db") && { echo "a disturbed tick was not found"; exit 1; }
[[ $said == "first difference in tick $tick: "* ]] || { echo "disturbed tick $tick, found: $said"; exit 1; }
# And where only a brick differs, the brick.
awk -v tick="$tick" '{ if ($1 == tick) sub(/:/, ":f", $NF); print }' "$work/da" >"$work/db"
brick=$(awk -v tick="$tick" '$1 == tick { split($NF, word, ":"); print word[1] }' "$work/da")
[[ $("$release" diff "$work/da" "$work/db" || true) == "first difference in tick $tick: brick $brick" ]] ||
  { echo "a changed brick was not named"; exit 1; }
echo "a disturbed tick is named: $said"
