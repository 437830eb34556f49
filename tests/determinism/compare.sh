#!/usr/bin/env bash
# Records attempts with one build of the core and re-runs each with every build: all must say the same,
# and agree with the recorded witness. ENAMEL_FULL=1: 20 recordings instead of 2.
set -euo pipefail
release=$1 builds=$2
others=()
for preset in core-clang-O0 core-clang-O3 core-gcc-O0; do
  [ -x "$builds/$preset/bin/core_replay" ] && others+=("$builds/$preset/bin/core_replay")
done
if [ ${#others[@]} -eq 0 ]; then
  echo "skipped: no other build of the core under $builds (./check makes one, ./check --full three)"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
count=2
[ "${ENAMEL_FULL:-0}" = 1 ] && count=20
for seed in $(seq "$count"); do
  "$release" record "$seed" "$work/t" "$work/v"
  "$release" replay "$work/t" "$work/v" >"$work/a"
  for other in "${others[@]}"; do
    "$other" replay "$work/t" "$work/v" >"$work/b" || true
    cmp "$work/a" "$work/b" || { diff "$work/a" "$work/b"; echo "seed $seed: $other disagrees"; exit 1; }
  done
  grep -q '^removed enamel [1-9]' "$work/a" || { echo "seed $seed: the recording cut nothing"; exit 1; }
  echo "seed $seed: $(grep state_hash "$work/a") $(grep final_volume "$work/a" | cut -c1-30)"
done
