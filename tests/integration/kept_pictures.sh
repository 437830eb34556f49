#!/usr/bin/env bash
# The teeth and exercises look as in tests/golden/pictures: all of them with ENAMEL_FULL=1; else those of a molar with
# caries, a bur and a dam, and an incisor in its mouth and prepared for a veneer. A picture that changed and one that is
# not kept are found. What differs is in ENAMEL_PICTURES, by default build/release/pictures.
. "$(dirname "$0")/support.sh"
start_display
export LIBGL_ALWAYS_SOFTWARE=1
out=${ENAMEL_PICTURES:-$(dirname "$bin")/pictures}
kept=$root/tests/golden/pictures
scenes=(molar-caries)
[ -z "${ENAMEL_FULL:-}" ] || scenes=()
"$bin/enamel-lab" pictures "${scenes[@]}" --compare "$kept" --out "$out" >"$work/log" 2>&1 ||
  { cat "$work/log"; fail "pictures have changed: look at them in $out"; }
cat "$work/log"

# Of four, one kept picture is another view's, and one is missing.
bur=incisor-labial.bur start=veneer-incisor-11-labial.start
mkdir "$work/kept"
cp "$kept"/incisor-labial.mouth.png "$kept"/veneer-incisor-11-labial.target.png "$work/kept"
cp "$kept/veneer-incisor-11-labial.target.png" "$work/kept/$bur.png"
expect_failure "a picture that changed" "$bur: changed: .*; to accept: cp $work/changed/$bur.png $work/kept/$bur.png" \
  "$bin/enamel-lab" pictures incisor-labial --compare "$work/kept" --out "$work/changed"
cat "$work/out"
grep -q "$start: not kept yet; to accept: cp $work/changed/$start.png" "$work/out" ||
  fail "a picture that is not kept was not found"
grep -q "4 pictures compared, different: 2" "$work/out" ||
  { mkdir -p "$out" && cp "$work"/changed/* "$out"; fail "pictures have changed: look at them in $out"; }
[ "$(cd "$work/changed" && echo *)" = "$bur.difference.png $bur.kept.png $bur.png $start.png" ] ||
  fail "expected what differs to be written, found $(ls "$work/changed")"
echo "ok: kept pictures"
