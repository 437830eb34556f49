#!/usr/bin/env bash
# A school in a data folder is moved to PostgreSQL and S3 stores and back, as an operator would do it, while a student's attempt
# is half uploaded: the station goes on with the server in its new place, and not a tick is lost. A backup is made of the
# cluster, verified and restored. with_postgres.sh and with_swift.sh start the stores.
. "$(dirname "$0")/../integration/support.sh"
folder=$work/folder cluster=$work/cluster station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-student1
stores=(--database "$ENAMEL_POSTGRES" --schema moved --s3-endpoint "$ENAMEL_S3_ENDPOINT" --s3-bucket "$ENAMEL_S3_BUCKET"
  --s3-region "$ENAMEL_S3_REGION" --key-bucket keys --master-key "$work/master.key")
verify() { "$bin/enamel-server" verify "$@" >"$work/verified" || { cat "$work/verified"; fail "verify $*"; }; }

"$bin/enamel-server" init --data "$folder" >/dev/null
"$bin/enamel-server" seed-demo --data "$folder" --voxel-um 150 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$folder" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name moved \
  --code "$("$bin/enamel-server" admin enrol-code --data "$folder")" >/dev/null
run=("$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise")
ENAMEL_PASSWORD=enamel-demo-instructor "${run[@]}" --user instructor --operator dentist --as-reference --json "$work/reference" >/dev/null
"$bin/enamel-server" report --data "$folder" --attempt "$(json_of "$work/reference" attempt_id)" --wait 600 >/dev/null
"$bin/enamel-server" admin mark-reference --data "$folder" --attempt "$(json_of "$work/reference" attempt_id)" \
  --dentist "Simulated dentist" --consent >/dev/null
run+=(--user student1)
"${run[@]}" --operator student --json "$work/first" >/dev/null
first=$(json_of "$work/first" attempt_id)
"$bin/enamel-server" report --data "$folder" --attempt "$first" --wait 600 --json "$work/first-report" >/dev/null

expect_failure "a move beside the server" "stop it first" "$bin/enamel-server" move --data "$folder" --to "$cluster" "${stores[@]}"
rm -rf "$cluster"
"${run[@]}" --operator good --uplink-kbit 200 --json "$work/second" >"$work/run.log" 2>&1 &
cutting=$!
pids+=("$cutting")
wait_for_log "$work/run.log" "begins"
chunk_files() { curl -s "http://127.0.0.1:$port/metrics" | sed -n 's/^enamel_chunks_committed_total //p'; }
before=$(chunk_files)
deadline=$((SECONDS + 120))
until [ "$(chunk_files)" -gt $((before + 2)) ]; do
  kill -0 "$cutting" 2>/dev/null || { cat "$work/run.log"; fail "the attempt ended before the server was stopped"; }
  [ $SECONDS -lt $deadline ] || { cat "$work/run.log"; fail "nothing came in for 120 s"; }
done
stop_server
kill -0 "$cutting" || fail "the attempt was over before the school was moved"

"$bin/enamel-server" move --data "$folder" --to "$cluster" "${stores[@]}" --json "$work/there"
expect_failure "a server on the old folder" "was moved to" "$bin/enamel-server" serve --data "$folder" --http 127.0.0.1:0 --stations 127.0.0.1:0
[ ! -e "$cluster/enamel.db" ] || fail "there are rows in the new folder"
start_server "$cluster" "$port"
ended=0
wait "$cutting" || ended=$?
case $ended in
  0) ;;
  # The move took longer than it waits for its server: exit 3, and nothing is lost.
  3) "$bin/enamel-station" upload --data "$station" >/dev/null || fail "the upload after the move" ;;
  *) cat "$work/run.log"; fail "the station ended with $ended" ;;
esac
second=$(json_of "$work/second" attempt_id)
"$bin/enamel-server" report --data "$cluster" --attempt "$second" --wait 600 --json "$work/report" >/dev/null
[ "$(json_of "$work/report" ticks)" = "$(json_of "$work/second" ticks)" ] ||
  fail "expected $(json_of "$work/second" ticks) ticks, found $(json_of "$work/report" ticks)"
echo "ok: $(json_of "$work/report" ticks) ticks of an attempt that began before the move"

"$bin/enamel-server" backup "$work/backup" --data "$cluster"
verify "$work/backup"
"$bin/enamel-server" restore "$work/backup" --data "$work/restored" >/dev/null
"$bin/enamel-server" report --data "$work/restored" --attempt "$second" >/dev/null
echo "ok: a backup of the cluster is whole and makes a folder"

# Whoever is erased is in no file of the database's tables.
files=$(psql -X -A -t -d "$ENAMEL_POSTGRES" -c 'SHOW data_directory')
name=$(psql -X -A -t -d "$ENAMEL_POSTGRES" -c "SELECT display_name FROM moved.people WHERE login = 'student2'")
psql -X -q -d "$ENAMEL_POSTGRES" -c CHECKPOINT
grep -qr "$name" "$files/base" || fail "expected \"$name\" in a file of $files/base before the erasure"
"$bin/enamel-server" admin erase-person --data "$cluster" --login student2 --confirm student2 >/dev/null
psql -X -q -d "$ENAMEL_POSTGRES" -c CHECKPOINT
! grep -qr "$name" "$files/base" || fail "\"$name\" is in $(grep -lr "$name" "$files/base")"
echo "ok: an erased name is in no file of base/"
stop_server

"$bin/enamel-server" move --data "$cluster" --to "$work/back" --json "$work/back.json" ||
  fail "the way back"
verify --data "$work/back" --since "$work/backup"
"$bin/enamel-server" report --data "$work/back" --attempt "$first" --json "$work/back-report" >/dev/null
cmp -s "$work/first-report" "$work/back-report" || { diff "$work/first-report" "$work/back-report"; fail "the first attempt's report is another"; }
start_server "$work/back" "$port"
"${run[@]}" --operator good --json "$work/third" >/dev/null
stop_server
echo "ok: back in a folder, as it was, and the station goes on"
