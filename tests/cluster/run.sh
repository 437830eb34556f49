#!/usr/bin/env bash
# What a cluster does and costs, beside one server with SQLite, in one run on this machine: three servers behind HAProxy,
# PostgreSQL with a synchronous standby, Swift as the S3 store.
#   tests/cluster/run.sh --short | --full [--json FILE] [--only PART[,PART…]]
# Parts: load, faults, rolling, watch, jobs; or hangs alone, whose links between machines need root. --short takes three minutes,
# --full an hour. Prints every figure with its goal; a goal that is missed is marked, and only what is lost, doubled or refused
# fails. Exit: 0, 1, 2 wrong usage, 77 packages are missing.
. "$(dirname "$0")/../integration/support.sh"
. "$root/tests/support/postgres_server.sh"
. "$root/tests/cluster/links.sh"
usage() { sed -n '2,8s/^# \{0,1\}//p' "$0"; }
size= json= only=load,faults,rolling,watch,jobs
while [ $# -gt 0 ]; do
  case $1 in
    --short | --full) size=${1#--} ;;
    --json) json=$(realpath -m "${2:?--json expects a file}"); shift ;;
    --only) only=${2:?--only expects parts}; shift ;;
    -h | --help) usage; exit 0 ;;
    *) echo "run.sh: expected --short or --full, found \"$1\"" >&2; usage >&2; exit 2 ;;
  esac
  shift
done
[ -n "$size" ] || { usage >&2; exit 2; }
[ "$only" = hangs ] || for part in ${only//,/ }; do
  case $part in
    load | faults | rolling | watch | jobs) ;;
    *) echo "run.sh: expected load, faults, rolling, watch or jobs after --only, or hangs alone, found \"$part\"" >&2; exit 2 ;;
  esac
done
for program in haproxy openssl node; do
  command -v $program >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
# Before Swift, which is on loopback too.
if [ "$only" = hangs ] && [ -z "${ENAMEL_LINKS:-}" ] && [ "$(id -u)" = 0 ] && unshare --net --mount ip link set lo up 2>/dev/null; then
  rm -rf "$work"
  trap - EXIT
  ENAMEL_LINKS=made exec unshare --net --mount "$0" "--$size" ${json:+--json "$json"} --only hangs
fi
if [ -z "${ENAMEL_S3_ENDPOINT:-}" ]; then
  [ -z "${ENAMEL_LINKS:-}" ] || links_make
  rm -rf "$work"
  trap - EXIT
  exec "$root/tests/cluster/with_swift.sh" "$0" "--$size" ${json:+--json "$json"} --only "$only"
fi
export ENAMEL_PG=$work/pg ENAMEL_WORK=$work ENAMEL_ROOT=$root ENAMEL_BIN=$bin ENAMEL_PAGE=$page_folder
mkdir "$ENAMEL_PG"
chmod 711 "$work"
postgres_user "$ENAMEL_PG"
end() {
  postgres_end "$ENAMEL_PG/one"
  postgres_end "$ENAMEL_PG/two"
  stop_all
}
trap end EXIT
if [ -n "${ENAMEL_LINKS:-}" ]; then
  links_tls "$work"
  cp "$work/pg.crt" "$work/pg.key" "$ENAMEL_PG"
  chown --reference="$ENAMEL_PG" "$ENAMEL_PG"/pg.*
  export ENAMEL_LINKS="-c listen_addresses=* -c ssl=on -c ssl_cert_file=$ENAMEL_PG/pg.crt -c ssl_key_file=$ENAMEL_PG/pg.key -c hba_file=$ENAMEL_PG/hba"
  printf 'local all all trust\nlocal replication all trust\nhostssl all all 192.0.2.0/28 trust\n' >"$ENAMEL_PG/hba"
  chmod 644 "$ENAMEL_PG/hba"
fi
postgres_pair "$ENAMEL_PG"
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=enamel.test -addext subjectAltName=DNS:enamel.test \
  -keyout "$work/page.key" -out "$work/page.crt" 2>/dev/null
cat "$work/page.crt" "$work/page.key" >"$work/page.pem"
work_of=run
[ "$only" != hangs ] || work_of=hangs
node "$root/tests/cluster/$work_of.mjs" "$size" "$(free_ports)" "$(free_ports)" "$only" "$json"
