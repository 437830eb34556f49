#!/usr/bin/env bash
# The whole way with the rows in PostgreSQL: a school is set up, a reference and a student's attempt are recorded,
# replayed, compared and scored, before and after the server ends. with_postgres.sh starts PostgreSQL.
. "$(dirname "$0")/support.sh"
data=$work/server station=$work/station
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-instructor

expect_failure "no such server" "cannot be reached" "$bin/enamel-server" init --data "$work/none" --database "host=$work dbname=none"
[ ! -e "$work/none/database.json" ] || fail "a folder is bound to a server that is not there"
"$bin/enamel-server" init --data "$work/none" --database "$ENAMEL_POSTGRES" --schema second_try
mkdir -m 755 "$work/home" && touch "$work/home/letter"
expect_failure "a folder of other things" "mode 0755 and with other things" "$bin/enamel-server" init --data "$work/home" --database "$ENAMEL_POSTGRES" --schema home
[ "$(stat -c %a "$work/home")" = 755 ] && [ ! -e "$work/home/database.json" ] || fail "a refused folder was changed"
"$bin/enamel-server" init --data "$data" --database "$ENAMEL_POSTGRES" --schema school
expect_failure "another database for the same folder" "already" "$bin/enamel-server" init --data "$data" --database "$ENAMEL_POSTGRES" --schema other
[ ! -e "$data/enamel.db" ] || fail "there are rows in the folder"
expect_failure "verify says what it cannot read" "make a backup" "$bin/enamel-server" verify --data "$data"

"$bin/enamel-server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
start_server "$data" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" --name postgres
attempt() {
  "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" \
    --user instructor --operator "$1" --json "$work/cut.json" "${@:2}" >/dev/null
  "$bin/enamel-server" report --data "$data" --attempt "$(json_of "$work/cut.json" attempt_id)" --wait 600 --json "$work/$1.json" >/dev/null
}
attempt dentist --as-reference
"$bin/enamel-server" admin mark-reference --data "$data" --attempt "$(json_of "$work/cut.json" attempt_id)" \
  --dentist "Simulated dentist" --consent >/dev/null
stop_server
start_server "$data" "$port"
attempt student-deep-mesial
node -e '
  const report = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  const wall = report.mistakes.find(({ kind, place }) => kind === "over_extended" && place === "wall_mesial");
  console.log(`score ${report.score}, mesial wall ${wall?.size} mm too far`);
  process.exit(report.score < 100 && wall && Math.abs(wall.size - 0.3) < 0.06 ? 0 : 1);' "$work/student-deep-mesial.json" ||
  { cat "$work/student-deep-mesial.json"; fail "the mesial wall is not found 0.3 mm over-extended"; }
rows=$(psql -X -A -t -d "$ENAMEL_POSTGRES" -c "SELECT count(*) FROM school.attempts WHERE state = 5")
[ "$rows" = 2 ] || fail "expected 2 scored attempts in PostgreSQL, found $rows"
echo "ok: two attempts are scored, and their rows are in PostgreSQL"
