#!/bin/bash
# Runs a command beside a private PostgreSQL server, empty, on a socket in a folder of its own, which
# ends with the command. ENAMEL_POSTGRES tells the command how to connect.
# Usage: with_postgres.sh COMMAND [ARGUMENT...]. Exit: the command's; 77: PostgreSQL is not here.
set -u -o pipefail

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
end() {
  [ -f "$folder/data/postmaster.pid" ] &&
    (cd "$folder" && "${as[@]}" "$programs/pg_ctl" -D "$folder/data" -m immediate -t 30 stop >/dev/null 2>&1)
  rm -rf "$folder"
}
trap end EXIT

# What is kept is asked of fsync elsewhere; here it would only cost time.
(cd "$folder" &&
  "${as[@]}" "$programs/initdb" -D "$folder/data" -A trust -U enamel -E UTF8 --locale=C --no-sync \
    >"$folder/initdb.log" 2>&1) || { cat "$folder/initdb.log"; exit 1; }
(cd "$folder" &&
  "${as[@]}" "$programs/pg_ctl" -D "$folder/data" -w -t 60 -l "$folder/server.log" \
    -o "-k $folder -c listen_addresses= -c fsync=off -c max_connections=200" start >/dev/null) ||
  { cat "$folder/server.log"; exit 1; }

export ENAMEL_POSTGRES="host=$folder user=enamel dbname=postgres"
export PATH="$PATH:$programs"
"$@"
