#!/usr/bin/env bash
# The Debian packages in a bare Debian: every command that docs/for_it.md has in a block of "sh", as it is written there,
# each unit with its user and folders, an attempt, and what remove, upgrade and purge leave. Needs root, debootstrap and a
# Debian archive.
#   debian.sh [12]  the packages of this checkout's build, on the machine's own Debian 12
#   debian.sh 13    packages that packaging/build makes in a second bare Debian 13, from HEAD; an hour on two cores
# ENAMEL_DEBIAN=FOLDER names a Debian that debootstrap has made before, to start from a copy of it. ENAMEL_BUILDER=FOLDER
# names the Debian 13 to build in, which keeps its compiler's cache.
set -euo pipefail
version=${1:-12}
case $version in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) echo "debian.sh: expected 12 or 13, found \"$version\"" >&2; exit 2 ;;
esac
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/tests/packaging/guide_blocks.sh"
build=${ENAMEL_BUILD:-$root/build/release}
skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*" >&2; exit 1; }
step() { printf '\n==> %s (%d s)\n' "$*" $SECONDS; }
[ "${ENAMEL_FULL:-}" = 1 ] || skip "ENAMEL_FULL=1 runs it"
[ "$(id -u)" = 0 ] || skip "needs root, for a chroot"
needed=(debootstrap ip)
[ $version = 13 ] || needed+=(cpack dpkg-shlibdeps)
for program in "${needed[@]}"; do command -v $program >/dev/null || skip "$program is not installed"; done
[ $version = 13 ] || grep -q '^VERSION_ID="12"' /etc/os-release || skip "packages for Debian 12 are built on Debian 12"

work=$(mktemp -d)
debian=$work/debian
# A network of its own, with nothing but loopback, and processes that end with it.
inside() {
  unshare -m -p -n --fork --kill-child bash -c '
    debian=$1; shift
    ip link set lo up
    mount -t proc proc "$debian/proc"; mount --rbind /dev "$debian/dev"; mount -t tmpfs tmpfs "$debian/run"
    exec chroot "$debian" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"
  ' _ "$debian" "$@"
}
online() { online_in "$debian" "$@"; }
online_in() { # online_in FOLDER COMMAND…: in that Debian, with the archive at hand
  unshare -m -p --fork --kill-child bash -c '
    debian=$1; shift
    mount -t proc proc "$debian/proc"; mount --bind /dev "$debian/dev"
    exec chroot "$debian" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"
  ' _ "$@"
}
logged() { "$@" >"$work/log" 2>&1 || { tail -n 30 "$work/log"; fail "$*"; }; }
trap 'rm -rf --one-file-system "$work"' EXIT

step "packages"
if [ $version = 13 ]; then
  builder=${ENAMEL_BUILDER:-$work/builder}
  [ -d "$builder/usr" ] || logged debootstrap --variant=minbase --include=git,ca-certificates,dpkg-dev $suite "$builder"
  rm -rf "$builder/src"
  logged git clone --no-local "$root" "$builder/src"
  logged git -C "$builder/src" checkout "$(git -C "$root" rev-parse HEAD)"
  chown -R root: "$builder/src"
  # Authorities that this machine trusts beside Debian's: npm asks its registry through the same network.
  cp -r /usr/local/share/ca-certificates "$builder/usr/local/share/"
  logged online_in "$builder" update-ca-certificates
  logged online_in "$builder" /src/packaging/build
  mv "$builder/src/build/release/packages" "$work/packages"
else
  logged cmake --build "$build" --target enamel_manuals enamel_sbom
  commit_time=$(git -C "$root" log -1 --format=%ct 2>/dev/null || date +%s)
  SOURCE_DATE_EPOCH=$commit_time logged cpack --config "$build/CPackConfig.cmake" -B "$work/packages"
fi
if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error "$work"/packages/*.deb || fail "lintian found an error"
fi

step "a bare Debian $version"
if [ -n "${ENAMEL_DEBIAN:-}" ]; then cp -a "$ENAMEL_DEBIAN" "$debian"
else logged debootstrap --variant=minbase $suite "$debian"
fi
mkdir "$debian/packages"
cp "$work"/packages/*.deb "$debian/packages"
online apt-get update -qq
# apt fetches now what the guide's two installs need; they then run without the archive.
online sh -c 'cd /packages && apt-get install -y -qq --download-only ./*.deb >/dev/null'
printf '127.0.0.1 localhost enamel.example.edu\n' >"$debian/etc/hosts"

if command -v gpg >/dev/null; then
  step "a signed repository"
  export GNUPGHOME=$work/gpg
  mkdir -m 700 "$GNUPGHOME"
  gpg --batch --quiet --passphrase '' --quick-gen-key test@enamel.example ed25519 sign never
  ENAMEL_PACKAGES=$work/packages "$root/packaging/repository" "$debian/srv/apt" test@enamel.example
  gpgconf --kill all
  mkdir -p "$debian/etc/apt/keyrings"
  cp "$debian/srv/apt/enamel.asc" "$debian/etc/apt/keyrings/"
  echo 'deb [signed-by=/etc/apt/keyrings/enamel.asc] file:/srv/apt ./' >"$debian/etc/apt/sources.list.d/enamel.list"
  online apt-get update -qq
  online apt-get install -qq --simulate enamel-server enamel-station enamel-lab enamel-doc >"$work/log" || fail "apt does not take the repository"
  rm "$debian/etc/apt/sources.list.d/enamel.list"
fi

# The guide's commands, with what a person would type in. "apt" asks.
sed '/^## Symptoms/,$d' "$root/docs/for_it.md" | guide_blocks - '```sh' |
  sed 's/^apt install/apt-get install -y -qq/; s/CODE@FINGERPRINT/"$(cat \/tmp\/code)"/; s/ admin enrol-code .*/& | tee \/tmp\/code/' >"$work/guide"
# The runbooks. A check may find something, but a command must exist and take its options.
sed -n '/^## Symptoms/,/^## Several servers/p' "$root/docs/for_it.md" | guide_blocks - '```sh' >"$work/runbooks"
[ "$(wc -l <"$work/runbooks")" -ge 15 ] || fail "found only $(wc -l <"$work/runbooks") commands of runbooks"
commands=$(sed '/^## Forty/,$d' "$root/docs/for_it.md" | guide_blocks - '```sh' | wc -l)
[ "$commands" -le 10 ] || fail "the guide takes $commands commands to a class; at most 10"
printf 'login,display_name,role,cohort\nanna,Anna,student,Year 3\nbob,Bob,student,Year 3\nvera,Vera,instructor,Year 3\n' >"$debian/tmp/year3.csv"
install -m 755 "$root/tests/packaging/systemctl" "$debian/root/systemctl"
cat >"$debian/root/trial" <<'TRIAL'
set -eu
fail() { echo "FAILED: $*" >&2; exit 1; }
until_log() { # until_log FILE TEXT
  for _ in $(seq 300); do grep -q "$2" "$1" && return 0; sleep 0.1; done
  cat "$1"; fail "$1 does not have \"$2\" within 30 s"
}
systemctl() {
  echo "# systemctl $*"
  [ "$1" != status ] || return 0
  /root/systemctl "$@" || exit 1
  case "$*" in *"--now enamel-server"* | "start enamel-server") until_log /var/log/enamel-server.service.log '^ready' ;; esac
}
# What the journal would have of a unit.
journalctl() { cat /var/log/enamel-server.service.log; }
cd /packages
TRIAL
# Each command is shown before it runs.
while IFS= read -r line; do
  printf 'echo %q\n%s\n' "\$ $line" "$line"
done <"$work/guide" >>"$debian/root/trial"
cat >>"$debian/root/trial" <<'TRIAL'
echo "# what is there now"
for file in man/man1/enamel-server.1.gz man/man1/enamel-station.1.gz bash-completion/completions/enamel-server \
  doc/enamel-server/all_settings.toml doc/enamel-server/changelog.gz doc/enamel-station/copyright doc/enamel-server/sbom.cdx.json doc/enamel-page/sbom.cdx.json; do
  [ -s /usr/share/$file ] || fail "/usr/share/$file is missing"
done
[ "$(stat -c '%a %U' /var/lib/enamel)" = "700 enamel" ] || fail "/var/lib/enamel is open to others"
[ "$(stat -c '%a %U' /var/lib/enamel-station)" = "700 enamel-station" ] || fail "/var/lib/enamel-station is open to others"
grep -q '^anna,' /tmp/passwords.csv || fail "no password for anna"
# The one-time password is for the page; here the student has chosen one.
runuser -u enamel -- sh -c 'echo "what anna chose" | enamel-server admin set-password --login anna --password-stdin --data /var/lib/enamel'
as_station() { runuser -u enamel-station -- "$@"; }
ENAMEL_PASSWORD="what anna chose" as_station enamel-station run --user anna --exercise class-1-molar-46 --profile phantom_desktop \
  --operator student --lockstep --quiet || fail "the first attempt"
runuser -u enamel -- enamel-server admin list-attempts --data /var/lib/enamel | grep -qi anna || fail "the server does not have the attempt"
as_station enamel-station doctor --no-graphics || true
echo "# commands of the other guides"
as_server() { runuser -u enamel -- enamel-server "$@" --data /var/lib/enamel; }
as_station enamel-station spool export last --out /tmp/attempt.trace
as_station enamel-station replay /tmp/attempt.trace --surface /tmp/tooth.ply
as_station enamel-station spool loops last >/dev/null
as_station enamel-station profiles >/dev/null
ENAMEL_PASSWORD="what anna chose" ENAMEL_PIN=271828 as_station enamel-station reserve --user anna --exercise class-1-molar-46 --profile phantom_desktop
as_server admin put-profile omega3
as_server retention --set recordings --days 730
as_server admin export-person /tmp/anna --login anna >/dev/null
as_server admin erase-person --login bob --confirm bob
TRIAL
echo 'echo "# runbooks"' >>"$debian/root/trial"
while IFS= read -r line; do
  printf 'echo %q\n{ %s; } || case $? in 1) ;; *) fail "ended with $?" ;; esac\n' "\$ $line" "$line"
done <"$work/runbooks" >>"$debian/root/trial"
cat >>"$debian/root/trial" <<'TRIAL'
echo "# every other unit"
systemd-analyze verify /usr/lib/systemd/system/enamel-*.service /usr/lib/systemd/system/enamel-*.timer
for unit in /usr/lib/systemd/system/enamel-*.service; do
  # Tenths. The station needs a display and devices.
  most=20; [ "${unit##*/}" != enamel-station.service ] || most=21
  systemd-analyze security --offline=true --threshold=$most "$unit" >/tmp/exposure || fail "$(tail -1 /tmp/exposure)"
done
systemctl start enamel-work.service
systemctl start enamel-station-upload.service
for unit in enamel-server enamel-work enamel-station; do
  if ! kill -0 "$(cat /run/stand-in/$unit.service.pid)" 2>/dev/null; then
    cat /var/log/$unit.service.log
    [ $unit = enamel-station ] && ! command -v cage >/dev/null || fail "$unit ended"
  fi
done
echo "# an upgrade restarts nothing"
before=$(cat /run/stand-in/enamel-server.service.pid)
echo '# changed' >>/etc/enamel/server.toml
apt-get install -y -qq --reinstall ./enamel-server_*.deb >/dev/null
kill -0 "$before" || fail "the upgrade ended the server"
grep -q '^# changed' /etc/enamel/server.toml || fail "the upgrade took a changed setting"
for unit in enamel-station enamel-work enamel-server; do /root/systemctl stop $unit; done
runuser -u enamel -- enamel-server verify --data /var/lib/enamel
echo "# remove, purge"
apt-get remove -y -qq enamel-server enamel-station >/dev/null
[ -f /etc/enamel/server.toml ] || fail "remove took the settings"
[ -f /var/lib/enamel/enamel.db ] || fail "remove took the data"
apt-get purge -y -qq enamel-server enamel-station | tee /tmp/purged
grep -q 'rm -r /var/backups/enamel' /tmp/purged || fail "purge does not say that the backups are kept"
[ ! -e /etc/enamel ] || fail "purge left /etc/enamel"
[ -f /var/lib/enamel/enamel.db ] || fail "purge took the data"
apt-get install -y -qq ./enamel-server_*.deb >/dev/null
ENAMEL_PURGE_RECORDINGS=yes apt-get purge -y -qq enamel-server
[ ! -e /var/lib/enamel ] || fail "purge kept the data although it was asked to delete it"
TRIAL
step "the guide: $commands commands to a class"
inside sh -c 'exec bash /root/trial'
step "done"
