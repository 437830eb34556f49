#!/usr/bin/env bash
# server/ops/pgbackrest.conf with PostgreSQL, Swift and a server: the database's files are lost, and come back as they were at
# a moment. What was recorded until then is whole, and who was erased since is erased again.
# Only with ENAMEL_FULL=1: pgBackRest is for databases that are too large for enamel-server backup.
. "$(dirname "$0")/../integration/support.sh"
. "$root/tests/support/postgres_server.sh"
[ -n "${ENAMEL_FULL:-}" ] || { echo "skipped: set ENAMEL_FULL=1"; exit 77; }
command -v pgbackrest >/dev/null || { echo "skipped: pgbackrest is not installed"; exit 77; }
if [ -z "${ENAMEL_S3_ENDPOINT:-}" ]; then
  rm -rf "$work"
  trap - EXIT
  exec "$root/tests/cluster/with_swift.sh" "$0"
fi
pg=$work/pg
mkdir "$pg"
chmod 711 "$work"
postgres_user "$pg"
end() {
  postgres_end "$pg/data"
  stop_all
}
trap end EXIT
for folder in repo socket backrest; do "${postgres_as[@]}" mkdir "$pg/$folder"; done
sed -e "s#^repo1-path=.*#repo1-path=$pg/repo#" -e "s#^pg1-path=.*#pg1-path=$pg/data#" \
  -e "s#^pg1-socket-path=.*#pg1-socket-path=$pg/socket\npg1-user=enamel\npg1-database=postgres#" \
  -e "s#^\[global\]#&\nlog-path=$pg/backrest\nlock-path=$pg/backrest\nspool-path=$pg/backrest#" \
  "$root/server/ops/pgbackrest.conf" >"$pg/pgbackrest.conf"
backrest() { (cd "$pg" && "${postgres_as[@]}" pgbackrest --config="$pg/pgbackrest.conf" --stanza=enamel "$@"); }
postgres_init "$pg/data"
cat >>"$pg/data/postgresql.conf" <<CONF
archive_mode = on
archive_command = 'pgbackrest --config=$pg/pgbackrest.conf --stanza=enamel archive-push %p'
CONF
postgres_start "$pg/data" "$pg/socket"
ask() { postgres_ask "$pg/socket" "$1" "${2:-enamel}"; }
ask "CREATE DATABASE enamel" postgres >/dev/null
backrest stanza-create
backrest check

data=$work/server station=$work/station
port=$(free_ports)
"$bin/enamel-server" init --data "$data" --database "host=$pg/socket user=enamel dbname=enamel" --schema school \
  --s3-endpoint "$ENAMEL_S3_ENDPOINT" --s3-bucket "$ENAMEL_S3_BUCKET" --s3-region "$ENAMEL_S3_REGION" \
  --key-bucket keys --master-key "$work/master.key" >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 150 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name restored \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" >/dev/null
# attempt FILE USER OPERATOR [OPTION…]: cut, handed in and scored.
attempt() {
  ENAMEL_PASSWORD=enamel-demo-$2 "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet \
    --exercise "$exercise" --user "$2" --operator "$3" --json "$work/$1" "${@:4}" >/dev/null
  "$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/$1" attempt_id)" --wait 600 --json "$work/$1.report" >/dev/null
}
attempt reference instructor dentist --as-reference
"$bin/enamel-server" admin mark-reference --data "$data" --attempt "$(json_of "$work/reference" attempt_id)" \
  --dentist "Simulated dentist" --consent >/dev/null
attempt erased student2 student
backrest backup
attempt kept student1 good
moment=$(ask "SELECT clock_timestamp()")
name=$(ask "SELECT display_name FROM school.people WHERE login = 'student2'")
"$bin/enamel-server" admin erase-person --data "$data" --login student2 --confirm student2 >/dev/null
attempt later student1 student
stop_server
ask "SELECT pg_switch_wal()" >/dev/null
# What was written last is in the archive before the files go.
postgres pg_ctl -D "$pg/data" -w -m fast stop >/dev/null
rm -rf "$pg/data"

"${postgres_as[@]}" mkdir -m 700 "$pg/data"
backrest --type=time --target="$moment" --target-action=promote restore
postgres_start "$pg/data" "$pg/socket"
deadline=$((SECONDS + 60))
until [ "$(ask "SELECT pg_is_in_recovery()")" = f ]; do
  [ $SECONDS -lt $deadline ] || { cat "$pg/data.log"; fail "the database was not restored within a minute"; }
done
[ "$(ask "SELECT count(*) FROM school.people WHERE display_name = '$name'")" = 1 ] || fail "the restored database is not of before the erasure"
start_server "$data" "$port"
[ "$(ask "SELECT count(*) FROM school.people WHERE display_name = '$name'")" = 0 ] || fail "\"$name\" was erased and is here again"
echo "ok: who was erased after the moment that was restored is erased again"
"$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/kept" attempt_id)" --json "$work/again.report" >/dev/null
cmp -s "$work/kept.report" "$work/again.report" || { diff "$work/kept.report" "$work/again.report"; fail "an attempt's report is another"; }
expect_failure "an attempt of after that moment" "attempt" "$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/later" attempt_id)"
stop_server
"$bin/enamel-server" backup "$work/backup" --data "$data" >/dev/null
"$bin/enamel-server" verify "$work/backup" >"$work/verified" || { cat "$work/verified"; fail "verify"; }
echo "ok: the school as it was then is whole"
