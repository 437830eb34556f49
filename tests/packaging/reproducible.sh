#!/usr/bin/env bash
# Two checkouts of one commit, in two folders, give the same packages to the byte. ENAMEL_FULL=1 only: it builds all programs
# twice, without ccache.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
skip() { echo "skipped: $*"; exit 77; }
[ "${ENAMEL_FULL:-}" = 1 ] || skip "ENAMEL_FULL=1 runs it"
for program in cpack dpkg-shlibdeps git; do command -v $program >/dev/null || skip "$program is not installed"; done
[ -z "$(git -C "$root" status --porcelain)" ] || skip "the checkout has changes that no commit has"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Neither is the checkout's own build: ccache with a base folder changes how a source is named in it.
for folder in one another_folder; do
  other=$work/$folder/enamel
  git clone -q "$root" "$other"
  git -C "$other" checkout -q "$(git -C "$root" rev-parse HEAD)"
  ln -s "$root/web/node_modules" "$other/web/node_modules"
  (cd "$other/web" && npm run --silent build >/dev/null)
  (cd "$other" && cmake --preset release >/dev/null &&
    CCACHE_DISABLE=1 cmake --build --preset release --target enamel_manuals enamel_sbom) >"$work/log" 2>&1 || { tail "$work/log"; exit 1; }
  SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct) \
    cpack --config "$other/build/release/CPackConfig.cmake" -B "$work/$folder/packages" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
done
failed=0
for package in "$work"/one/packages/*.deb; do
  name=$(basename "$package")
  if cmp "$package" "$work/another_folder/packages/$name"; then echo "equal: $name"; else failed=1; fi
done
exit $failed
