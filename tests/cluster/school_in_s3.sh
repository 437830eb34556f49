#!/usr/bin/env bash
# A data folder whose rows are in PostgreSQL and whose blobs are in a real S3 store: what cannot be is refused before
# anything is bound to it, the demo's content goes into the bucket, and no secret into the folder.
# with_postgres.sh and with_swift.sh start both.
. "$(dirname "$0")/../integration/support.sh"
data=$work/server
s3=(--s3-endpoint "$ENAMEL_S3_ENDPOINT" --s3-bucket "$ENAMEL_S3_BUCKET" --s3-region "$ENAMEL_S3_REGION" --s3-prefix school/)

expect_failure "rows in SQLite" "expected --database" "$bin/enamel-server" init --data "$work/none" "${s3[@]}"
expect_failure "no such bucket" "NoSuchBucket" "$bin/enamel-server" init --data "$work/none" --database "$ENAMEL_POSTGRES" \
  --s3-endpoint "$ENAMEL_S3_ENDPOINT" --s3-bucket absent
AWS_SECRET_ACCESS_KEY=wrong expect_failure "wrong secret" "SignatureDoesNotMatch" "$bin/enamel-server" init --data "$work/none" \
  --database "$ENAMEL_POSTGRES" "${s3[@]}"
[ ! -e "$work/none" ] || fail "a folder was made for a store that cannot be used"

by_key=("$bin/enamel-server" init --database "$ENAMEL_POSTGRES" --schema by_key "${s3[@]}" --s3-access-key "$AWS_ACCESS_KEY_ID")
expect_failure "no secret" "expected the secret" "${by_key[@]}" --data "$work/none"
expect_failure "wrong secret" "SignatureDoesNotMatch" bash -c 'echo wrong | "$@"' - "${by_key[@]}" --data "$work/none"
[ ! -e "$work/none" ] || fail "a folder was made for a key that cannot be used"
(
  secret=$AWS_SECRET_ACCESS_KEY
  unset AWS_SECRET_ACCESS_KEY
  "${by_key[@]}" --data "$work/by_key" <<<"$secret" >/dev/null
  "$bin/enamel-server" admin list-exercises --data "$work/by_key" >/dev/null
)
[ "$(stat -c %a "$work/by_key/s3.json")" = 600 ] || fail "others may read the access key"

"$bin/enamel-server" init --data "$data" --database "$ENAMEL_POSTGRES" --schema school "${s3[@]}" >/dev/null
! grep -rq "$AWS_SECRET_ACCESS_KEY" "$data" || fail "the secret is in the data folder"
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
[ -z "$(find "$data/blobs" -type f)" ] || fail "there are blobs in the folder"
blobs=$(psql "$ENAMEL_POSTGRES" -Atc 'SELECT count(*) FROM school.blobs')
[ "$blobs" -gt 3 ] || fail "expected the demo's blobs in the store, found $blobs rows"
"$bin/enamel-server" admin list-exercises --data "$data" | grep -q class-1 || fail "the exercise is not there"
echo "$blobs blobs in the S3 store"

# integration/metrics.sh has no bucket, and leaves these to this script.
port=$(free_ports)
start_server "$data" "$port"
curl -s "http://127.0.0.1:$port/metrics" >"$work/metrics"
for name in $(grep -oh 'enamel_s3_[a-z_]*' "$root/server/ops/prometheus_rules.yml" "$root/server/ops/grafana_dashboard.json" | sort -u); do
  grep -q "^$name{of=\"blobs\"}" "$work/metrics" || { cat "$work/metrics"; fail "$name is no figure of a server with a bucket"; }
done
# The server asks the store every two seconds.
for _ in $(seq 600); do
  ! curl -s "http://127.0.0.1:$port/metrics" | grep '^enamel_s3_requests_total{of="blobs"} [1-9]' >/dev/null || break
  sleep 0.1
done
curl -s "http://127.0.0.1:$port/metrics" | grep '^enamel_s3_requests_total{of="blobs"} [1-9]' >/dev/null ||
  fail "a minute after the start no request to the store is counted"
stop_server
echo "the store's figures are there"
