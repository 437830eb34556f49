#!/usr/bin/env bash
# Two servers of one school behind the HAProxy of server/ops/haproxy.cfg: rows in PostgreSQL, blobs and keys in S3 stores.
# The second is made with the identity of the first, and refused without. While a station uploads, one server after the
# other is killed: not a tick is lost, the recording is scored, and who was signed in stays so. Whom one server erases is
# erased for the other. The attempt is watched and spoken to at both. with_postgres.sh and with_swift.sh start the stores.
. "$(dirname "$0")/../integration/support.sh"
for program in haproxy curl openssl; do
  command -v $program >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
one=$work/one two=$work/two station=$work/station
port=$(free_ports)
page=$(free_ports)
export ENAMEL_PASSWORD="a quite unlikely password 7"
school=(--database "$ENAMEL_POSTGRES" --schema two --s3-endpoint "$ENAMEL_S3_ENDPOINT" --s3-bucket "$ENAMEL_S3_BUCKET"
  --s3-region "$ENAMEL_S3_REGION")
keys=(--key-bucket keys --master-key "$work/master.key")
rows() { PGOPTIONS="-c search_path=two" psql -X -A -t -d "$ENAMEL_POSTGRES" -c "$1"; }

expect_failure "keys where versions are kept" "forgets what is deleted" "$bin/enamel-server" init --data "$one" "${school[@]}" \
  --key-bucket versioned --master-key "$work/master.key"
expect_failure "no master key named" "master-key" "$bin/enamel-server" init --data "$one" "${school[@]}" --key-bucket keys
expect_failure "one bucket for both" "another for blobs" "$bin/enamel-server" init --data "$one" "${school[@]}" \
  --key-bucket "$ENAMEL_S3_BUCKET" --master-key "$work/master.key"
[ ! -e "$one" ] || fail "a folder was made for stores that cannot be used"
"$bin/enamel-server" init --data "$one" "${school[@]}" "${keys[@]}" >"$work/first"
[ "$(stat -c %a "$work/master.key")" = 600 ] || fail "others may read the master key"
expect_failure "a second server of its own" "identity" "$bin/enamel-server" init --data "$two" "${school[@]}" "${keys[@]}"
mkdir "$work/identity"
expect_failure "an empty identity" "no readable ticket.key" "$bin/enamel-server" init --data "$two" "${school[@]}" "${keys[@]}" --identity "$work/identity"
cp "$one"/station.crt "$one"/station.key "$one"/ticket.key "$work/identity"
expect_failure "a mistyped master key" "no such file" "$bin/enamel-server" init --data "$two" "${school[@]}" --key-bucket keys \
  --master-key "$work/mastre.key" --identity "$work/identity"
[ ! -e "$work/mastre.key" ] || fail "a second master key was made"
expect_failure "keys in the folder" "key ring of the other servers" "$bin/enamel-server" init --data "$two" "${school[@]}" --identity "$work/identity"
[ ! -e "$two/database.json" ] || fail "the folder is bound to what was refused"
"$bin/enamel-server" init --data "$two" "${school[@]}" "${keys[@]}" --identity "$work/identity" >"$work/second"
[ "$(sed 's/.*fingerprint//' "$work/first")" = "$(sed 's/.*fingerprint//' "$work/second")" ] || fail "two fingerprints: $(cat "$work/first" "$work/second")"
"$bin/enamel-server" init --data "$work/other" >/dev/null
expect_failure "another school's identity" "found another" "$bin/enamel-server" init --data "$two" "${school[@]}" "${keys[@]}" --identity "$work/other"

"$bin/enamel-server" seed-demo --data "$one" --voxel-um 150 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
for login in admin instructor student1 student2; do
  printf '%s\n' "$ENAMEL_PASSWORD" | "$bin/enamel-server" admin set-password --data "$two" --login "$login" --password-stdin >/dev/null
done

openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=enamel.test -addext subjectAltName=DNS:enamel.test \
  -keyout "$work/page.key" -out "$work/page.crt" 2>/dev/null
cat "$work/page.crt" "$work/page.key" >"$work/page.pem"
declare -A server
# serve NAME ADDRESS
serve() {
  "$bin/enamel-server" serve --data "$work/$1" --http "$2:$port" --stations "$2:$((port + 1))" --web "$page_folder" \
    --http-behind-proxy 127.0.0.1 --stations-behind-proxy 127.0.0.1 --host-name enamel.test >"$work/$1.log" 2>&1 &
  server[$1]=$!
  pids+=($!)
  wait_for_log "$work/$1.log" '^ready'
}
kill_at_once() {
  kill -KILL "${server[$1]}"
  wait "${server[$1]}" 2>/dev/null || true
}
serve one 127.0.0.1
serve two 127.0.0.2
export ENAMEL_PAGE_ADDRESS=127.0.0.1:$page ENAMEL_STATIONS_ADDRESS=127.0.0.1:$((page + 1)) ENAMEL_PAGE_CERTIFICATE=$work/page.pem
export ENAMEL_HOST_NAME=enamel.test ENAMEL_SERVER_ONE=127.0.0.1 ENAMEL_SERVER_TWO=127.0.0.2
export ENAMEL_SERVER_PAGE_PORT=$port ENAMEL_SERVER_STATION_PORT=$((port + 1))
haproxy -f "$root/server/ops/haproxy.cfg" >"$work/haproxy.log" 2>&1 &
pids+=($!)
# ask PATH [options]: the page as a browser asks for it, signed in; prints the status.
ask() {
  local path=$1
  shift
  curl -s -o "$work/answer" -w '%{http_code}' -b "$work/cookies" -c "$work/cookies" --cacert "$work/page.crt" \
    --retry 20 --retry-connrefused --retry-delay 1 --resolve "enamel.test:$page:127.0.0.1" "$@" "https://enamel.test:$page$path"
}
status=$(ask /api/v1/session -H 'Content-Type: application/json' -H "Origin: https://enamel.test:$page" -d "{\"login\": \"instructor\", \"password\": \"$ENAMEL_PASSWORD\"}")
[ "$status" = 201 ] || [ "$status" = 200 ] || fail "signing in was answered $status: $(cat "$work/answer")"
cp "$work/answer" "$work/session"

"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((page + 1))" --code "$("$bin/enamel-server" admin enrol-code --data "$two")" --name round
run=("$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise")
"${run[@]}" --user instructor --operator dentist --as-reference --json "$work/reference.json" >/dev/null
"$bin/enamel-server" report --data "$two" --attempt "$(json_of "$work/reference.json" attempt_id)" --wait 300 >/dev/null
"$bin/enamel-server" admin mark-reference --data "$one" --attempt "$(json_of "$work/reference.json" attempt_id)" --dentist "Simulated dentist" --consent >/dev/null

committed() { rows "SELECT coalesce(max(chunks), 0) FROM attempts WHERE sealed_ms = 0"; }
# Until more of the attempt is kept than so many chunks.
until_more_than() {
  local deadline=$((SECONDS + 120))
  until [ "$(committed)" -gt "$1" ]; do
    kill -0 "$cutting" 2>/dev/null || { cat "$work/run.log"; fail "the attempt ended before the servers were killed"; }
    [ $SECONDS -lt $deadline ] || { tail -n 20 "$work"/*.log; fail "nothing came in for 120 s"; }
  done
}
"${run[@]}" --user student1 --operator good --uplink-kbit 200 --json "$work/cut.json" >"$work/run.log" 2>&1 &
cutting=$!
pids+=("$cutting")
until_more_than 1
# The station is with one of them, and can be watched at either: asked as the proxy asks.
being_made=$(rows "SELECT encode(id, 'hex') FROM attempts WHERE sealed_ms = 0 AND chunks > 0" | sed -E 's/^(.{8})(.{4})(.{4})(.{4})/\1-\2-\3-\4-/')
cookie=$(awk '$6 ~ /enamel_session/ { print $6 "=" $7 }' "$work/cookies")
# ask_at ADDRESS PATH [options]: prints the answer.
ask_at() {
  local address=$1 path=$2
  shift 2
  curl -sN -H "Cookie: $cookie" -H "Host: enamel.test" -H 'X-Forwarded-Proto: https' -H 'X-Forwarded-For: 192.0.2.1' "$@" \
    "http://$address:$port/api/v1$path"
}
for address in 127.0.0.1 127.0.0.2; do
  ask_at "$address" "/attempts/$being_made/live" --max-time 4 >"$work/live" || true
  moments=$({ grep -o '\],\[\|"rows":\[\[' "$work/live" || true; } | wc -l)  # grep fails where it finds none
  [ "$moments" -gt 50 ] || fail "expected more than 50 moments in 4 s at $address, found $moments: $(head -c 300 "$work/live")"
  echo "ok: $moments moments in 4 s at $address"
done
# What is said at either is shown at the chair, and both know that it was.
csrf=$(json_of "$work/session" csrf)
for address in 127.0.0.1 127.0.0.2; do
  ask_at "$address" "/live/$being_made/remarks" -H 'Content-Type: application/json' -H 'Origin: https://enamel.test' \
    -H "X-Enamel-CSRF: $csrf" -d "{\"text\": \"Said at $address.\"}" >"$work/said"
  grep -q '"state":"waiting"' "$work/said" || fail "a remark at $address: $(cat "$work/said")"
done
shown_at() { ask_at "$1" "/live/$being_made/remarks" | grep -o '"state":"shown"' | wc -l; }
for address in 127.0.0.1 127.0.0.2; do
  deadline=$((SECONDS + 60))
  until [ "$(shown_at "$address")" = 2 ]; do
    [ $SECONDS -lt $deadline ] || fail "at $address: $(ask_at "$address" "/live/$being_made/remarks")"
  done
done
echo "ok: remarks said at both servers were shown"
# Each is killed once.
kill_at_once one
before=$(committed)
until_more_than "$before"
[ "$(ask /api/v1/session)" = 200 ] || fail "who was signed in is not: $(cat "$work/answer")"
# HAProxy's check must see that it is gone before it is back, or it never says "UP".
wait_for_log "$work/haproxy.log" 'station_servers/one is DOWN'
serve one 127.0.0.1
wait_for_log "$work/haproxy.log" 'station_servers/one is UP'
kill_at_once two
before=$(committed)
[ "$(ask /api/v1/session)" = 200 ] || fail "who was signed in is not: $(cat "$work/answer")"
wait "$cutting" || { cat "$work/run.log"; fail "the station ended with an error"; }
id=$(json_of "$work/cut.json" attempt_id)
"$bin/enamel-server" report --data "$one" --attempt "$id" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" ticks)" = "$(json_of "$work/cut.json" ticks)" ] || fail "expected $(json_of "$work/cut.json" ticks) ticks, found $(json_of "$work/report.json" ticks)"
[ "$(rows "SELECT count(*) FROM attempt_results WHERE attempt = (SELECT id FROM attempts WHERE sealed_ms > 0 ORDER BY ticketed_ms DESC LIMIT 1)")" = 1 ] || fail "expected one result"
echo "ok: $(json_of "$work/cut.json" ticks) ticks past two servers that were killed, scored $(json_of "$work/report.json" score)"

serve two 127.0.0.2
"$bin/enamel-server" admin erase-person --data "$two" --login student1 --confirm student1 >/dev/null
expect_failure "an attempt of an erased person, at the other server" "no attempt" "$bin/enamel-server" report --data "$one" --attempt "$id"
[ "$(rows "SELECT count(*) FROM person_keys")" = 1 ] || fail "expected the instructor's key alone"
echo "ok: erased for both"
