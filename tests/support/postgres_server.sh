# PostgreSQL servers of a test's own, each with its socket in a folder and gone with it. Sourced by scripts.
#   postgres_user FOLDER                    who runs them gets the folder. Exits with 77 where PostgreSQL is not here
#   postgres PROGRAM [ARGUMENT...]          one of PostgreSQL's programs, as that user
#   postgres_init DATA                      a new server's files; its user is enamel
#   postgres_start DATA SOCKETS [OPTION...] returns when it answers
#   postgres_end DATA                       at once
#   postgres_pair FOLDER                    FOLDER/one, and its synchronous standby FOLDER/two, with sockets in
#                                           FOLDER/one.socket and FOLDER/two.socket and a database enamel
#   postgres_standby FOLDER FROM NAME       FOLDER/NAME as a new synchronous standby of FOLDER/FROM, which runs
# With ENAMEL_LINKS a server runs in the network namespace of its folder's name (tests/cluster/links.sh), with these options.
#   postgres_ask SOCKETS SQL [DATABASE [USER]]
postgres_programs=$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | sort -V | tail -1)
postgres_as=()
postgres_at=()
postgres_user() {
  if [ ! -x "$postgres_programs/initdb" ] || [ ! -x "$postgres_programs/psql" ]; then
    echo "SKIPPED: PostgreSQL's initdb and psql are not installed"
    exit 77
  fi
  PATH=$PATH:$postgres_programs
  postgres_folder=$1
  # PostgreSQL does not run as root.
  [ "$(id -u)" = 0 ] || return 0
  local user=postgres
  id "$user" >/dev/null 2>&1 || user=nobody
  postgres_as=(setpriv "--reuid=$user" "--regid=$(id -g "$user")" --clear-groups)
  chown "$user" "$1"
  if ! "${postgres_as[@]}" test -w "$1"; then
    echo "SKIPPED: this is root, and no other user can be had to run PostgreSQL"
    exit 77
  fi
}
postgres() { (cd "$postgres_folder" && "${postgres_at[@]}" "${postgres_as[@]}" "$postgres_programs/$1" "${@:2}"); }
postgres_init() {
  postgres initdb -D "$1" -A trust -U enamel -E UTF8 --locale=C --no-sync >"$1.initdb.log" 2>&1 || { cat "$1.initdb.log"; exit 1; }
}
# What is kept is asked of fsync elsewhere; here it would only cost time. server/ops/patroni.yml says why the interval.
postgres_start() {
  local postgres_at=()
  [ -z "${ENAMEL_LINKS:-}" ] || postgres_at=(nsenter "--net=/run/netns/$(basename "$1")")
  postgres pg_ctl -D "$1" -w -t 60 -l "$1.log" \
    -o "-k $2 -c listen_addresses= -c fsync=off -c max_connections=200 -c wal_retrieve_retry_interval=500ms ${ENAMEL_LINKS:-} ${*:3}" start >/dev/null || { cat "$1.log"; exit 1; }
}
postgres_end() {
  [ ! -f "$1/postmaster.pid" ] || postgres pg_ctl -D "$1" -m immediate -t 30 stop >/dev/null 2>&1 || true
}
postgres_ask() { psql -X -A -t -d "host=$1 user=${4:-enamel} dbname=${3:-enamel}" -c "$2"; }
postgres_standby() {
  rm -rf "$1/$3"
  postgres pg_basebackup -d "host=$1/$2.socket user=enamel application_name=$3" -D "$1/$3" -R -X stream -c fast --no-sync
  postgres_start "$1/$3" "$1/$3.socket" -c "cluster_name=$3"
}
postgres_pair() {
  local name
  for name in one two; do "${postgres_as[@]}" mkdir "$1/$name.socket"; done
  postgres_init "$1/one"
  postgres_start "$1/one" "$1/one.socket"
  postgres_ask "$1/one.socket" "CREATE DATABASE enamel" postgres >/dev/null
  # The primary's alone: the standby would wait for itself once it has taken over. From its start on, so that the first
  # commit waits until there is a synchronous standby.
  postgres pg_ctl -D "$1/one" -w -m fast stop >/dev/null
  postgres_start "$1/one" "$1/one.socket" -c synchronous_standby_names=two
  postgres_standby "$1" one two
  postgres_ask "$1/one.socket" "CREATE TABLE first_commit (n int)" >/dev/null
  [ "$(postgres_ask "$1/one.socket" "SELECT sync_state FROM pg_stat_replication")" = sync ] || { echo "there is no synchronous standby"; exit 1; }
}
