#!/bin/bash
# Whether PostgreSQL understands every statement of the store: runs the storage suite, which notes
# what it asks of SQLite, then prepares each statement on a private PostgreSQL server with the same
# tables. Usage: postgres.sh SERVER_STORAGE_TEST. Exit 77: PostgreSQL is not here.
set -u -o pipefail

suite=$(realpath "$1")
programs=$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | sort -V | tail -1)
if [ ! -x "$programs/initdb" ] || [ ! -x "$programs/psql" ]; then
  echo "SKIPPED: PostgreSQL's initdb and psql are not installed"
  exit 77
fi

# PostgreSQL does not run as root.
as=()
folder=$(mktemp -d /tmp/enamel-pg.XXXXXX)
if [ "$(id -u)" = 0 ]; then
  user=postgres
  id "$user" >/dev/null 2>&1 || user=nobody
  as=(setpriv "--reuid=$user" "--regid=$(id -g "$user")" --clear-groups)
  chown "$user" "$folder"
  if ! "${as[@]}" test -w "$folder"; then
    echo "SKIPPED: this is root, and no other user can be had to run PostgreSQL"
    rm -rf "$folder"
    exit 77
  fi
fi
cd "$folder" || exit 1
end() {
  [ -f "$folder/data/postmaster.pid" ] &&
    "${as[@]}" "$programs/pg_ctl" -D "$folder/data" -m immediate -t 30 stop >/dev/null 2>&1
  rm -rf "$folder"
}
trap end EXIT

noted=$folder/noted
if ! ENAMEL_STATEMENTS=$noted timeout 400 "$suite" --gtest_filter='Backends/*/Sqlite' \
  >"$folder/suite.log" 2>&1; then
  tail -n 30 "$folder/suite.log"
  echo "the suite itself failed"
  exit 1
fi

"${as[@]}" "$programs/initdb" -D "$folder/data" -A trust -U enamel -E UTF8 --locale=C --no-sync \
  >"$folder/initdb.log" 2>&1 || { cat "$folder/initdb.log"; exit 1; }
"${as[@]}" "$programs/pg_ctl" -D "$folder/data" -w -t 60 -l "$folder/server.log" \
  -o "-k $folder -c listen_addresses= -c fsync=off" start >/dev/null || { cat "$folder/server.log"; exit 1; }
ask() { timeout 60 "$programs/psql" -X -q -h "$folder" -U enamel -d postgres "$@"; }

# SQLite's types in PostgreSQL's words.
sed -E -e 's/\bBLOB\b/bytea/g' -e 's/\bINTEGER\b/bigint/g' -e 's/\bREAL\b/double precision/g' \
  -e 's/\) *STRICT(, WITHOUT ROWID)?$/)/' -e 's/^--$/;/' \
  -e 's/^CREATE TABLE /CREATE TABLE IF NOT EXISTS /' "$noted.tables" >"$folder/tables.sql"
# What a driver for PostgreSQL has to bring.
cat >"$folder/driver.sql" <<'SQL'
CREATE FUNCTION json_extract(document text, path text) RETURNS text
  LANGUAGE sql AS $$ SELECT document::json ->> substr(path, 3) $$;
SQL
ask -v ON_ERROR_STOP=1 -f "$folder/driver.sql" || exit 1
# A table may name one that comes after it.
for _ in 1 2 3; do ask -f "$folder/tables.sql" >"$folder/tables.log" 2>&1; done
if grep -q ERROR "$folder/tables.log"; then
  grep -A4 ERROR "$folder/tables.log"
  exit 1
fi

# ?1 is the tenant in every statement of the store; what has none is SQLite's own.
awk -v RS='\n--\n' '/\?1/ { gsub(/\?[0-9]+/, "$&"); s = $0; gsub(/\$\?/, "$", s); printf "PREPARE s%d AS %s;\n", ++n, s }' \
  "$noted.statements" >"$folder/statements.sql"
count=$(grep -c '^PREPARE ' "$folder/statements.sql")
ask -f "$folder/statements.sql" >"$folder/answers.log" 2>&1
if grep -q ERROR "$folder/answers.log" || [ "$count" -lt 150 ]; then
  grep -A4 ERROR "$folder/answers.log"
  echo "of $count statements, $(grep -c ERROR "$folder/answers.log") are none to PostgreSQL"
  exit 1
fi
echo "$count statements are prepared"
