#!/usr/bin/env bash
# disk_full.sh [STATIONS]: STATIONS stations (20) stream into a file system of its own (64 MiB in memory) that is
# filled up to the last block while they do, and emptied again some seconds later: the server says that it takes no
# recordings, stays up, and takes them again; nothing that was committed is lost. Skipped where no file system may
# be mounted.
. "$(dirname "$0")/../integration/support.sh"
if [ "${ENAMEL_IN_NAMESPACE:-}" != 1 ]; then
  unshare -m true 2>/dev/null && exec env ENAMEL_IN_NAMESPACE=1 unshare -m "$0" "$@"
  unshare -Urm true 2>/dev/null && exec env ENAMEL_IN_NAMESPACE=1 unshare -Urm "$0" "$@"
  echo "skipped: this machine does not let a file system be mounted"
  exit 77
fi
stations=${1:-20}
data=$work/small
mkdir "$data"
trap 'umount -l "$data" 2>/dev/null || true; stop_all' EXIT
export ENAMEL_MIN_FREE_MIB=4
mount -t tmpfs -o size=64m none "$data" || { echo "skipped: no file system could be mounted"; exit 77; }
# What the server says goes elsewhere, as to a journal: on the full disk it would get lost.
mkdir -m 700 "$data/server"
: >"$work/server.log"
ln -s "$work/server.log" "$data/server/server.log"
"$bin/enamel-loadgen" --stations "$stations" --minutes 0.4 --loop-seconds 5 --data "$data/server" --json "$work/load.json" 2>"$work/load.log" &
load=$!
pids+=("$load")
until grep -q "^streaming" "$work/load.log"; do
  kill -0 "$load" 2>/dev/null || { cat "$work/load.log"; fail "the load did not start"; }
  sleep 0.2
done
sleep 4
dd if=/dev/zero of="$data/filler" bs=64k 2>/dev/null || true
wait_for_log "$work/server.log" "no recordings are taken:.*disk is full"
sleep 3  # of the load, without room
full=$(df --output=avail "$data" | tail -n 1)
rm "$data/filler"
wait_for_log "$work/server.log" "recordings are taken again"
wait "$load" || { tail -n 20 "$work/load.log"; cat "$work/server.log"; fail "something that was committed is not there once"; }
"$bin/enamel-server" verify --data "$data/server" >"$work/verify" 2>&1 || { cat "$work/verify"; fail "the server's data does not agree with itself"; }
echo "full to $full KiB while $stations stations streamed:$(grep -o '"ticks_committed":[0-9]*' "$work/load.json" | cut -d: -f2 | sed 's/^/ /') ticks committed, none lost or doubled"
tail -n 1 "$work/verify"
