#!/usr/bin/env bash
# Two checkouts of one commit, in two folders, give the same packages to the byte. ENAMEL_FULL=1 only: it builds all programs
# again, without ccache.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${ENAMEL_BUILD:-$root/build/release}
skip() { echo "skipped: $*"; exit 77; }
[ "${ENAMEL_FULL:-}" = 1 ] || skip "ENAMEL_FULL=1 runs it"
for program in cpack dpkg-shlibdeps git; do command -v $program >/dev/null || skip "$program is not installed"; done
[ -z "$(git -C "$root" status --porcelain)" ] || skip "the checkout has changes that no commit has"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
other=$work/another_folder/enamel
git clone -q "$root" "$other"
git -C "$other" checkout -q "$(git -C "$root" rev-parse HEAD)"
ln -s "$root/web/node_modules" "$other/web/node_modules"
for checkout in "$root" "$other"; do
  out=$build
  [ "$checkout" = "$root" ] || out=$other/build/release
  (cd "$checkout/web" && npm run --silent build >/dev/null)
  (cd "$checkout" && cmake --preset release -B "$out" >/dev/null &&
    CCACHE_DISABLE=1 cmake --build "$out" --target enamel_manuals enamel_sbom) >"$work/log" 2>&1 || { tail "$work/log"; exit 1; }
  SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct) \
    cpack --config "$out/CPackConfig.cmake" -B "$work/packages_$(basename "$(dirname "$checkout")")" >"$work/log" 2>&1 ||
    { cat "$work/log"; exit 1; }
done
failed=0
first=$work/packages_$(basename "$(dirname "$root")") second=$work/packages_another_folder
for package in "$first"/*.deb; do
  name=$(basename "$package")
  if cmp "$package" "$second/$name"; then echo "equal: $name"; else failed=1; fi
done
exit $failed
