#!/bin/bash
# Runs a command beside a private PostgreSQL server, empty, on a socket in a folder of its own, which
# ends with the command. ENAMEL_POSTGRES tells the command how to connect.
# Usage: with_postgres.sh COMMAND [ARGUMENT...]. Exit: the command's; 77: PostgreSQL is not here.
set -u -o pipefail
. "$(dirname "$0")/postgres_server.sh"
folder=$(mktemp -d /tmp/enamel-pg.XXXXXX)
end() {
  postgres_end "$folder/data"
  rm -rf "$folder"
}
trap end EXIT
postgres_user "$folder"
postgres_init "$folder/data"
postgres_start "$folder/data" "$folder"

export ENAMEL_POSTGRES="host=$folder user=enamel dbname=postgres" PATH
"$@"
