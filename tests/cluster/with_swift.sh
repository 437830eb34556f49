#!/bin/bash
# Runs a command beside a private OpenStack Swift with its S3 API, empty but for the buckets "blobs" and "keys", on
# loopback and in a folder of its own, which ends with the command. ENAMEL_S3_ENDPOINT, ENAMEL_S3_REGION, ENAMEL_S3_BUCKET,
# AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY tell the command how to ask it.
# Usage: with_swift.sh COMMAND [ARGUMENT...]. Exit: the command's; 77: Swift is not here.
set -u -o pipefail

for program in swift-proxy-server swift-account-server swift-container-server swift-object-server python3; do
  command -v $program >/dev/null || {
    echo "SKIPPED: Swift's $program is not installed (packages swift, swift-proxy, swift-account, swift-container, swift-object)"
    exit 77
  }
done
/usr/bin/python3 -c 'import swift' 2>/dev/null || {
  echo "SKIPPED: Swift's library is not installed (package python3-swift)"
  exit 77
}

# Servers of Swift give up root: they run as whoever owns the folder.
user=$(id -un)
as=()
folder=$(mktemp -d /tmp/enamel-swift.XXXXXX)
pids=()
end() {
  [ ${#pids[@]} -eq 0 ] || kill "${pids[@]}" 2>/dev/null
  for pid in "${pids[@]}"; do
    # At most five seconds each.
    timeout 5 tail --pid="$pid" -f /dev/null || kill -9 "$pid" 2>/dev/null
  done
  wait 2>/dev/null
  rm -rf "$folder"
}
trap end EXIT
if [ "$(id -u)" = 0 ]; then
  user=swift
  id "$user" >/dev/null 2>&1 || user=nobody
  as=(setpriv "--reuid=$user" "--regid=$(id -g "$user")" --clear-groups)
  chown "$user" "$folder"
  if ! "${as[@]}" test -w "$folder"; then
    echo "SKIPPED: this is root, and no other user can be had to run Swift"
    exit 77
  fi
fi

# Ports that are free now; nothing is started at the last.
read -r proxy account container object nothing < <(python3 -c '
import socket
held = [socket.socket() for _ in range(5)]
for s in held: s.bind(("127.0.0.1", 0))
print(*[s.getsockname()[1] for s in held])')

mkdir -p "$folder/disk/d"
cat >"$folder/swift.conf" <<CONF
[swift-hash]
swift_hash_path_suffix = enamel
swift_hash_path_prefix = enamel
[storage-policy:0]
name = only
default = yes
CONF
server() {  # kind port pipeline
  cat >"$folder/$1-server.conf" <<CONF
[DEFAULT]
bind_ip = 127.0.0.1
bind_port = $2
user = $user
swift_dir = $folder
devices = $folder/disk
mount_check = false
workers = 0
log_address = $folder/none
fallocate_reserve = 0
[pipeline:main]
pipeline = $1-server
[app:$1-server]
use = egg:swift#$1
CONF
}
server account "$account"
server container "$container"
server object "$object"
# A ring each, with one disk. As swift-ring-builder does it, which would take a second for each of nine calls.
/usr/bin/python3 - "$folder" "account:$account" "container:$container" "object:$object" <<'PY' || exit 1
import sys
from swift.common.ring import RingBuilder
for kind, port in (ring.split(":") for ring in sys.argv[2:]):
    builder = RingBuilder(4, 1, 0)
    builder.add_dev({"region": 1, "zone": 1, "ip": "127.0.0.1", "port": int(port), "device": "d", "weight": 1,
                     "replication_ip": "127.0.0.1", "replication_port": int(port), "meta": ""})
    builder.rebalance()
    builder.get_ring().save(f"{sys.argv[1]}/{kind}.ring.gz")
PY
# tempauth wants a memcached named. There is none at that port: Swift asks its servers each time.
cat >"$folder/proxy-server.conf" <<CONF
[DEFAULT]
bind_ip = 127.0.0.1
bind_port = $proxy
user = $user
swift_dir = $folder
workers = 0
log_address = $folder/none
[pipeline:main]
pipeline = catch_errors gatekeeper proxy-logging cache listing_formats s3api tempauth copy slo dlo versioned_writes symlink proxy-logging proxy-server
[app:proxy-server]
use = egg:swift#proxy
account_autocreate = true
[filter:catch_errors]
use = egg:swift#catch_errors
[filter:gatekeeper]
use = egg:swift#gatekeeper
[filter:proxy-logging]
use = egg:swift#proxy_logging
[filter:cache]
use = egg:swift#memcache
memcache_servers = 127.0.0.1:$nothing
[filter:listing_formats]
use = egg:swift#listing_formats
[filter:s3api]
use = egg:swift#s3api
location = us-east-1
[filter:tempauth]
use = egg:swift#tempauth
user_test_tester = testing .admin .reseller_admin
[filter:copy]
use = egg:swift#copy
[filter:slo]
use = egg:swift#slo
[filter:dlo]
use = egg:swift#dlo
[filter:versioned_writes]
use = egg:swift#versioned_writes
allow_object_versioning = true
[filter:symlink]
use = egg:swift#symlink
CONF
chown -R "$user" "$folder" 2>/dev/null
for kind in account container object proxy; do
  "${as[@]}" swift-$kind-server "$folder/$kind-server.conf" >"$folder/$kind.log" 2>&1 &
  pids+=($!)
done
export ENAMEL_S3_ENDPOINT="http://127.0.0.1:$proxy" ENAMEL_S3_REGION=us-east-1 ENAMEL_S3_BUCKET=blobs
export AWS_ACCESS_KEY_ID=test:tester AWS_SECRET_ACCESS_KEY=testing
# Until all four answer, at most a minute; then the buckets are made: "blobs", "keys", and "versioned", which keeps versions.
python3 - "$proxy" "$account" "$container" "$object" <<'PY' || { tail -n 20 "$folder"/*.log; exit 1; }
import datetime, hashlib, hmac, http.client, socket, sys, time
ports = [int(p) for p in sys.argv[1:]]
until = time.monotonic() + 60
for port in ports:
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), 1).close()
            break
        except OSError:
            if time.monotonic() > until:
                sys.exit(f"nothing listens on port {port}")
            time.sleep(0.1)

def put(path, query, body):
    """AWS Signature Version 4, apart from the code that is tested."""
    host = f"127.0.0.1:{ports[0]}"
    now = datetime.datetime.now(datetime.timezone.utc).strftime("%Y%m%dT%H%M%SZ")
    digest = hashlib.sha256(body).hexdigest()
    names = "host;x-amz-content-sha256;x-amz-date"
    canonical = "\n".join(["PUT", path, query, f"host:{host}", f"x-amz-content-sha256:{digest}",
                           f"x-amz-date:{now}", "", names, digest])
    scope = f"{now[:8]}/us-east-1/s3/aws4_request"
    text = "\n".join(["AWS4-HMAC-SHA256", now, scope, hashlib.sha256(canonical.encode()).hexdigest()])
    key = b"AWS4testing"
    for part in scope.split("/") + [text]:
        key = hmac.new(key, part.encode(), hashlib.sha256).digest()
    connection = http.client.HTTPConnection(host, timeout=30)
    connection.request("PUT", path + ("?" + query.rstrip("=") if query else ""), body, {
        "x-amz-content-sha256": digest, "x-amz-date": now, "Authorization":
        f"AWS4-HMAC-SHA256 Credential=test:tester/{scope},SignedHeaders={names},Signature={key.hex()}"})
    answer = connection.getresponse()
    found = answer.read()
    if answer.status >= 300:
        sys.exit(f"PUT {path}?{query}: {answer.status} {found.decode()}")

put("/blobs", "", b"")
put("/keys", "", b"")
put("/versioned", "", b"")
put("/versioned", "versioning=", b'<VersioningConfiguration xmlns="http://s3.amazonaws.com/doc/2006-03-01/">'
    b"<Status>Enabled</Status></VersioningConfiguration>")
PY
"$@"
