#!/usr/bin/env bash
# packaging/release refuses what cannot be released and says what is missing; with ENAMEL_FULL=1 it makes a release of HEAD
# twice, equal to the byte, whose sources run without npm. That builds everything in a clone: half an hour on two cores.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
command -v git >/dev/null || { echo "skipped: git is not installed"; exit 77; }
work=$(mktemp -d)
trap 'gpgconf --kill all 2>/dev/null || true; rm -rf "$work"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
export GIT_AUTHOR_NAME=test GIT_AUTHOR_EMAIL=test@enamel.example GIT_COMMITTER_NAME=test GIT_COMMITTER_EMAIL=test@enamel.example
export GIT_CONFIG_GLOBAL=/dev/null GNUPGHOME=$work/gpg
mkdir -m 700 "$GNUPGHOME"

fill_in() { # fill_in FOLDER: what a maintainer does before a release
  printf 'repository: https://enamel.example\nmail: mail@enamel.example\nsecurity: security@enamel.example\n' >"$1/CONTACT"
  sed -i "0,/^## .*/s//## $(cat "$1/VERSION") - 2026-01-01/" "$1/CHANGELOG.md"
}
few=$work/few
mkdir -p "$few/packaging"
cp "$root"/packaging/{release,commit} "$few/packaging"
cp "$root"/{VERSION,CHANGELOG.md,.gitattributes} "$few"
fill_in "$few"
cd "$few"
git init -q
commit() { git add -A && git commit -q --allow-empty -m "$1"; }
# refused WHAT TEXT [OPTION…]
refused() {
  local rc=0
  packaging/release --check "${@:3}" >"$work/out" 2>&1 || rc=$?
  [ $rc = 1 ] && grep -qF -- "$2" "$work/out" || { cat "$work/out"; fail "$1: exit code $rc, expected 1 and \"$2\""; }
}
commit first
packaging/release --check >/dev/null || fail "a commit that has everything is refused"
touch new
refused "a file that no commit has" "expected a clean tree"
rm new
for name in repository mail security; do
  sed -i "s/^$name:.*/$name:/" CONTACT && commit "no $name"
  refused "no $name" "CONTACT has no $name"
  git revert --no-edit HEAD >/dev/null
done
echo 0.9 >VERSION && commit "a version of two parts"
refused "a version of two parts" "expected a version such as"
echo 99.0.0 >VERSION && commit "another version"
refused "a version that CHANGELOG.md does not describe" 'expected to begin with "99.0.0 - '
cp "$root/VERSION" . && sed -i "0,/^## .*/s//## Unreleased ($(cat VERSION))/" CHANGELOG.md && commit "unreleased"
refused "a version that is not released" 'found "Unreleased ('
fill_in . && commit "as before"
! command -v gpg >/dev/null || refused "a key that nobody has" "gpg has no secret key nobody@enamel.example" --key nobody@enamel.example
packaging/release --check --out >"$work/out" 2>&1 && fail "--out without a folder is accepted" || [ $? = 2 ] || fail "--out without a folder: another exit code than 2"
packaging/release --help | grep -q SHA256SUMS.asc || fail "--help does not say what a release has"

# An archive knows its commit as the checkout does; a copy in another checkout does not take that one's.
mkdir "$work/archive"
git archive HEAD | tar -x -C "$work/archive"
[ "$("$work/archive/packaging/commit")" = "$(packaging/commit)" ] || fail "an archive says \"$("$work/archive/packaging/commit")\", the checkout \"$(packaging/commit)\""
mkdir copy && cp -r packaging copy
[ -z "$(copy/packaging/commit)" ] || fail "a copy of the sources names the commit around it"
echo "ok: what cannot be released is refused"

[ "${ENAMEL_FULL:-}" = 1 ] || exit 0
skip() { echo "skipped: $*"; exit 77; }
for program in cpack gpg mmdebstrap umoci; do command -v $program >/dev/null || skip "$program is not installed"; done
gpg --batch --quiet --passphrase '' --quick-gen-key test@enamel.example ed25519 sign never
git clone -q "$root" "$work/clone"
cd "$work/clone"
fill_in .
commit "a release"
for folder in one two; do
  packaging/release --out "$work/$folder" --key test@enamel.example >"$work/log" 2>&1 || { tail -n 30 "$work/log"; fail "packaging/release"; }
done
cd "$work/one"
gpg --batch --verify SHA256SUMS.asc SHA256SUMS 2>/dev/null || fail "the signature is not of SHA256SUMS"
sha256sum --quiet --check SHA256SUMS || fail "SHA256SUMS"
for file in *; do
  [ "$file" = SHA256SUMS.asc ] || cmp "$file" "../two/$file" || fail "$file differs between two runs"
done
tar -x -C "$work" -f enamel-*.tar.xz
cd "$work"/enamel-*/
.ci/page --fresh || fail "the page in the archive is older than its sources: trying them needs npm"
[ "$(packaging/commit)" = "$(cd "$work/clone" && packaging/commit)" ] || fail "the archive does not know its commit"
echo "ok: $(ls "$work/one" | wc -l) files of a release, equal to the byte in two runs"
