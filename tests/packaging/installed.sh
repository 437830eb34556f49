#!/usr/bin/env bash
# What the install rules put where: installed.sh BUILD. Each component into a folder of its own; nothing is built.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
wrong() { echo "FAILED: $*" >&2; failed=1; }

for part in server station lab import page doc; do
  DESTDIR=$work/$part cmake --install "$build" --prefix /usr --component $part >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
  (cd "$work/$part" && find . -type f | sed 's/^\.//') | sort | tee "$work/$part.files" >>"$work/all"
  [ -s "$work/$part.files" ] || wrong "component $part is empty"
done
sort "$work/all" | uniq -d | while read -r path; do echo "in two packages, which dpkg refuses: $path"; done >"$work/twice"
[ ! -s "$work/twice" ] || wrong "$(cat "$work/twice")"
has() { grep -qxF "$1" "$work/all"; }

# Paths of ours that units, settings and guides name. Not installed here: what an admin makes, and
# what packaging/build makes of the programs' help.
made='/usr/share/doc/enamel-server/all_settings.toml|/usr/share/doc/enamel/html/index.html|/etc/udev/rules.d/61-enamel.rules|/etc/enamel/(page\.(crt|key)|master\.key|server\.env|falcon\.bin)|/etc/enamel/?$|/usr/share/doc/enamel-server/examples$'
grep -hoE '/(usr/[a-z]+|etc)/[A-Za-z0-9/_.-]*enamel[A-Za-z0-9/_.-]*' "$root"/docs/*.md "$root"/schemas/*.md \
  "$root"/{server,station}/ops/*.{service,timer,toml} | sed 's/[.:]*$//' | sort -u | grep -vE "^($made)" >"$work/named"
while read -r path; do
  has "$path" || grep -qF "$path/" "$work/all" || wrong "$path is named by a unit, its settings or a guide, and no package has it"
done <"$work/named"

# Whoever reads the guides there finds what they link to.
doc=$work/doc/usr/share/doc/enamel
ln -sfn "$root/LICENSE" "$doc/LICENSE"  # a link to Debian's copy, which a computer need not have
node "$root/tests/packaging/links.mjs" "$doc" || wrong "the guides have broken links where they are installed"
node "$root/tests/packaging/site.mjs" "$doc" || wrong "the site made of the guides is not whole where they are installed"

# Each unit's user and folder are made by its own package, and settings that somebody may have changed survive an upgrade.
for part in server station; do
  for unit in "$root/$part"/ops/*.service; do
    user=$(sed -n 's/^User=//p' "$unit")
    grep -q "^u $user " "$root/packaging/$part/sysusers.conf" || wrong "$(basename "$unit"): no package makes the user $user"
    folder=$(sed -n 's/^StateDirectory=//p' "$unit")
    [ -z "$folder" ] || grep -q "^d /var/lib/$folder 0700 $user " "$root/packaging/$part/tmpfiles.conf" ||
      wrong "$(basename "$unit"): no package makes /var/lib/$folder"
  done
  diff <(grep '^/etc/' "$work/$part.files") <(sort "$root/packaging/$part/conffiles") >"$work/diff" ||
    wrong "packaging/$part/conffiles is not what $part has in /etc: $(cat "$work/diff")"
  for script in postinst prerm postrm; do sh -n "$root/packaging/$part/$script" || wrong "$part/$script is no shell script"; done
done

# Purging names what it leaves, and deletes only what it was asked to.
sed "s#/var/#$work/var/#g" "$root/packaging/server/postrm" >"$work/postrm"
mkdir -p "$work"/var/{lib,backups}/enamel
touch "$work"/var/{lib,backups}/enamel/kept
purged=$(sh "$work/postrm" purge)
for folder in lib backups; do
  [[ $purged = *"rm -r $work/var/$folder/enamel"* ]] || wrong "purge does not say how to delete /var/$folder/enamel"
done
[ -e "$work/var/lib/enamel/kept" ] || wrong "purge took the data"
purged=$(ENAMEL_PURGE_RECORDINGS=yes sh "$work/postrm" purge)
[ ! -e "$work/var/lib/enamel" ] && [ -e "$work/var/backups/enamel/kept" ] && [[ $purged != *var/lib* ]] ||
  wrong "purge with ENAMEL_PURGE_RECORDINGS=yes deletes other than the data, or says so"

if command -v apparmor_parser >/dev/null; then
  for part in server station; do
    profile=$work/$part/usr/share/doc/enamel-$part/examples/apparmor-enamel-$part
    apparmor_parser --skip-kernel-load --skip-cache "$profile" >"$work/log" 2>&1 || wrong "$(cat "$work/log")"
  done
fi

# Programs say which commit they are of, and nothing about the computer that built them.
for program in server station lab; do
  file=$work/$program/usr/bin/enamel-$program
  said=$("$file" --version)
  [[ $said =~ ^enamel-$program\ [0-9.]+( \([0-9a-f]{7,}(-changed)?\))?$ ]] || wrong "--version says \"$said\""
  [ ! -e "$root/.git" ] || [[ $said = *\(* ]] || wrong "\"$said\" does not name the commit"
  ! grep -aoF "$root/" "$file" | head -n 1 | grep . || wrong "enamel-$program has the folder that it was built in, $root"
done
exit $failed
