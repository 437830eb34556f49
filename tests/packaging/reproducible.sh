#!/usr/bin/env bash
# Equal to the byte, with ENAMEL_FULL=1: the smallest program, built without ccache from two checkouts of one commit in folders
# of different names; and all packages, made twice from the checkout's own build. It says how many bytes differ.
#   reproducible.sh        some minutes on two cores
#   reproducible.sh --all  builds and packs everything in both checkouts: hours on two cores
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${ENAMEL_BUILD:-$root/build/release}
skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*" >&2; exit 1; }
[ "${ENAMEL_FULL:-}" = 1 ] || [ "${1:-}" = --all ] || skip "ENAMEL_FULL=1 runs it"
for program in cpack dpkg-shlibdeps git; do command -v $program >/dev/null || skip "$program is not installed"; done
[ -z "$(git -C "$root" status --porcelain)" ] || skip "the checkout has changes that no commit has"
SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct)
export SOURCE_DATE_EPOCH
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
folders=(one another_folder)

logged() { "$@" >"$work/log" 2>&1 || { tail "$work/log"; fail "$*"; }; }
# build_in FOLDER TARGET…. Not the checkout's own build: ccache with a base folder changes how a source is named in it.
build_in() {
  local checkout=$work/$1/enamel
  logged git clone "$root" "$checkout"
  logged git -C "$checkout" checkout "$(git -C "$root" rev-parse HEAD)"
  ln -s "$root/web/node_modules" "$checkout/web/node_modules"
  cd "$checkout"
  logged cmake --preset release
  CCACHE_DISABLE=1 logged cmake --build --preset release --target "${@:2}"
  cd "$root"
}
pack() { logged cpack --config "$1/CPackConfig.cmake" -B "$work/$2/packages"; }  # pack BUILD FOLDER
# compare FILE OTHER: sets differing when they are not equal.
differing=0
compare() {
  local bytes
  [ -s "$1" ] && [ -s "$2" ] || fail "$1 or $2 is missing"
  bytes=$({ cmp -l "$1" "$2" 2>/dev/null || true; } | wc -l)
  [ "$(stat -c %s "$1")" = "$(stat -c %s "$2")" ] || bytes="$bytes, and the sizes,"
  echo "$(basename "$1"): $(stat -c %s "$1") bytes, $bytes differ"
  [ "$bytes" = 0 ] || differing=1
}
compare_packages() {
  local package
  [ "$(ls "$work/one/packages"/*.deb | wc -l)" -ge 6 ] || fail "there are not six packages"
  for package in "$work"/one/packages/*.deb; do compare "$package" "$work/another_folder/packages/$(basename "$package")"; done
}

if [ "${1:-}" = --all ]; then
  for folder in "${folders[@]}"; do
    build_in $folder enamel_manuals enamel_sbom
    (cd "$work/$folder/enamel/web" && logged npm run --silent build)
    pack "$work/$folder/enamel/build/release" $folder
  done
  compare_packages
  exit $differing
fi
for folder in "${folders[@]}"; do build_in $folder enamel-import-child; done
compare "$work"/{one,another_folder}/enamel/build/release/bin/enamel-import-child
logged cmake --build "$build" --target enamel_manuals enamel_sbom
for folder in "${folders[@]}"; do pack "$build" $folder; done
compare_packages
exit $differing
