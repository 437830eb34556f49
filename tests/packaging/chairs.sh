#!/usr/bin/env bash
# A room of forty chairs in a bare Debian, from the packages: one table of codes, three chairs set up over ssh by the Ansible role
# of packaging/ansible, the others enrolled by hand, and an attempt sent from each of the three at once. Every chair
# is a chroot of its own; all share a network that has loopback only. Needs root, debootstrap, ansible, ssh and a Debian archive.
# ENAMEL_DEBIAN=FOLDER names a Debian that debootstrap has made before, to start from a copy of it.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${ENAMEL_BUILD:-$root/build/release}
skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*" >&2; exit 1; }
step() { printf '\n==> %s (%d s)\n' "$*" $SECONDS; }
command -v ansible-playbook >/dev/null || skip "ansible-playbook is not installed"
(cd "$root/packaging/ansible" && ansible-playbook --syntax-check -i chairs.ini chairs.yml) || fail "the role is not valid"
[ "${ENAMEL_FULL:-}" = 1 ] || { echo "valid; ENAMEL_FULL=1 also runs it"; exit 0; }
[ "$(id -u)" = 0 ] || skip "needs root, for a chroot"
for program in debootstrap cpack dpkg-shlibdeps dpkg-scanpackages gpg ip ssh ssh-keygen; do
  command -v $program >/dev/null || skip "$program is not installed"
done
grep -q '^VERSION_ID="12"' /etc/os-release || skip "packages for Debian 12 are built on Debian 12"

if [ -z "${ENAMEL_IN_NAMESPACE:-}" ]; then
  work=$(mktemp -d)
  trap 'rm -rf --one-file-system "$work"' EXIT
  step "packages, in a signed repository"
  cmake --build "$build" --target enamel_manuals enamel_sbom >"$work/log" 2>&1 || { tail "$work/log"; fail "building"; }
  cpack --config "$build/CPackConfig.cmake" -B "$work/packages" >"$work/log" 2>&1 || { cat "$work/log"; fail "cpack"; }
  step "a bare Debian"
  if [ -n "${ENAMEL_DEBIAN:-}" ]; then cp -a "$ENAMEL_DEBIAN" "$work/debian"
  else debootstrap --variant=minbase bookworm "$work/debian" >"$work/log" 2>&1 || { tail "$work/log"; fail "debootstrap"; }
  fi
  export GNUPGHOME=$work/gpg
  mkdir -m 700 "$GNUPGHOME"
  gpg --batch --quiet --passphrase '' --quick-gen-key test@enamel.example ed25519 sign never
  ENAMEL_PACKAGES=$work/packages "$root/packaging/repository" "$work/debian/srv/apt" test@enamel.example >/dev/null
  gpgconf --kill all
  unshare -m -p --fork --kill-child bash -c '
    debian=$1
    mount -t proc proc "$debian/proc"; mount --bind /dev "$debian/dev"
    run() { chroot "$debian" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive "$@"; }
    run apt-get update -qq
    run apt-get install -y -qq --no-install-recommends openssh-server python3 python3-apt iproute2
    # What the station needs of Debian; the role installs the station itself.
    run sh -c "apt-get install -y -qq --no-install-recommends /srv/apt/enamel-*.deb && apt-get purge -y -qq enamel-station"
    rm -f "$debian"/etc/apt/sources.list
  ' _ "$work/debian" >"$work/log" 2>&1 || { tail -n 20 "$work/log"; fail "apt"; }
  printf '127.0.0.1 localhost enamel.example.edu\n' >"$work/debian/etc/hosts"
  ssh-keygen -q -t ed25519 -N '' -f "$work/key"
  ENAMEL_IN_NAMESPACE=$work unshare -m -p -n --fork --kill-child "$0"
  exit
fi

work=$ENAMEL_IN_NAMESPACE
ip link set lo up
mount -t tmpfs tmpfs "$work/gpg"
machine() { # machine NAME: a copy of the Debian whose changes are its own
  mkdir -p "$work/gpg/$1"/{upper,work} "$work/$1"
  mount -t overlay overlay -o "lowerdir=$work/debian,upperdir=$work/gpg/$1/upper,workdir=$work/gpg/$1/work" "$work/$1"
  mount -t proc proc "$work/$1/proc"; mount --rbind /dev "$work/$1/dev"; mount -t tmpfs tmpfs "$work/$1/run"
}
on() { # on NAME COMMAND…
  local name=$1; shift
  chroot "$work/$name" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root "$@"
}
as_server() { on server runuser -u enamel -- enamel-server "$@"; }

step "the server, and forty codes"
machine server
seq -f 'chair-%02g' 40 >"$work/chairs"
on server sed -i 's/^stations = .*/stations = "127.0.0.1:8443"/' /etc/enamel/server.toml
as_server serve --config /etc/enamel/server.toml >"$work/server.log" 2>&1 &
for _ in $(seq 300); do grep -q '^ready' "$work/server.log" && break; sleep 0.1; done
grep -q '^ready' "$work/server.log" || { cat "$work/server.log"; fail "the server is not ready within 30 s"; }
as_server admin add-person --data /var/lib/enamel --login head --role admin >/dev/null
as_server admin publish-exercise --data /var/lib/enamel --scene builtin:molar --name class-1 >/dev/null
as_server admin add-person --data /var/lib/enamel --login anna --role student --password-stdin <<<"what anna chose" >/dev/null
as_server admin add-cohort --data /var/lib/enamel --name class >/dev/null
as_server admin add-to-cohort --data /var/lib/enamel --cohort class --login anna >/dev/null
as_server admin enrol-code --data /var/lib/enamel --names - --minutes 600 <"$work/chairs" >"$work/codes.csv"

step "three chairs, by the role"
cp -r "$root/packaging/ansible" "$work/ansible"
{
  echo '[chairs]'
  for n in 1 2 3; do echo "chair-0$n ansible_host=127.0.0.1 ansible_port=220$n"; done
  printf '[chairs:vars]\nansible_user=root\nansible_python_interpreter=/usr/bin/python3\nenamel_repository=file:///srv/apt\n'
  echo "enamel_server=enamel.example.edu:8443"
} >"$work/ansible/chairs.ini"
for n in 1 2 3; do
  machine "chair-0$n"
  mkdir -p "$work/chair-0$n/run/sshd" "$work/chair-0$n/root/.ssh"
  cp "$work/key.pub" "$work/chair-0$n/root/.ssh/authorized_keys"
  on "chair-0$n" /usr/sbin/sshd -D -p "220$n" -o UsePAM=no -o PidFile=none 2>>"$work/sshd.log" &
done
export ANSIBLE_HOST_KEY_CHECKING=False ANSIBLE_SSH_RETRIES=10 ANSIBLE_PRIVATE_KEY_FILE=$work/key ANSIBLE_NOCOWS=1 HOME=$work
play() {
  # No systemd runs here.
  (cd "$work/ansible" && ansible-playbook -i chairs.ini chairs.yml -e "enamel_codes=$work/codes.csv" \
    -e '{"enamel_settings": {"keep-days": 14}}' --skip-tags units) >"$work/play.log" 2>&1 || { cat "$work/play.log"; fail "the role"; }
}
play
grep -E '^chair-0[123]' "$work/play.log"
for n in 1 2 3; do grep -qx 'keep-days = 14' "$work/chair-0$n/etc/enamel/station.toml" || fail "chair-0$n has no setting of the role"; done
play
[ "$(grep -c 'changed=0 ' "$work/play.log")" = 3 ] || { cat "$work/play.log"; fail "a second run changed something"; }

step "the other thirty-seven, on one machine"
for n in $(seq -f %02g 4 40); do
  on chair-01 runuser -u enamel-station -- enamel-station enrol --server enamel.example.edu:8443 --codes - --name "chair-$n" \
    --data "/var/lib/enamel-station/chair-$n" <"$work/codes.csv" >/dev/null
done
[ "$(as_server admin list-stations --data /var/lib/enamel | grep -c 'chair-[0-9][0-9]')" = 40 ] ||
  { as_server admin list-stations --data /var/lib/enamel; fail "the server does not have forty chairs"; }

step "three attempts at once"
pids=()
for n in 1 2 3; do
  on "chair-0$n" ENAMEL_PASSWORD="what anna chose" runuser -u enamel-station -- enamel-station run --user anna \
    --exercise class-1-molar-46 --profile phantom_desktop --operator student --lockstep --quiet >"$work/run$n" 2>&1 &
  pids+=($!)
done
for pid in "${pids[@]}"; do wait "$pid" || { cat "$work"/run?; fail "an attempt"; }; done
[ "$(as_server admin list-attempts --data /var/lib/enamel | grep -ci anna)" = 3 ] ||
  { as_server admin list-attempts --data /var/lib/enamel; fail "the server does not have the three attempts"; }
step "done"
