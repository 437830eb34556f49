#!/usr/bin/env bash
# What a school costs a server that serves it beside its own while nobody uses it: threads, memory, open files and
# processor time without other schools and with ten, and connections to PostgreSQL where ENAMEL_POSTGRES names one.
#   tests/bench/school_cost.sh
#   tests/support/with_postgres.sh tests/bench/school_cost.sh
. "$(dirname "$0")/../integration/support.sh"
data=$work/installation
port=$(free_ports)
stores=()
[ -z "${ENAMEL_POSTGRES:-}" ] || stores=(--database "$ENAMEL_POSTGRES" --schema cost)
"$bin/enamel-server" init --data "$data" ${stores[@]+"${stores[@]}"} >/dev/null
start_server "$data" "$port"
look() {
  local before after connections=-
  before=$(awk '{print $14 + $15}' "/proc/$server/stat")
  sleep 20  # over which the processor's time is taken
  after=$(awk '{print $14 + $15}' "/proc/$server/stat")
  [ -z "${ENAMEL_POSTGRES:-}" ] || connections=$(psql -X -A -t -d "$ENAMEL_POSTGRES" -c \
    "SELECT count(*) FROM pg_stat_activity WHERE backend_type = 'client backend' AND pid <> pg_backend_pid()")
  echo "$1 other schools: $(find "/proc/$server/task" -mindepth 1 -maxdepth 1 | wc -l) threads," \
    "$(awk '/VmRSS/ {printf "%.1f", $2 / 1024}' "/proc/$server/status") MiB, $(find "/proc/$server/fd" -mindepth 1 | wc -l) open files," \
    "$connections connections, $(awk -v t=$((after - before)) -v hz="$(getconf CLK_TCK)" 'BEGIN {printf "%.2f", 100 * t / hz / 20}') % of a core"
}
look 0
for i in $(seq 10); do "$bin/enamel-server" school add "s$i" --host "s$i.test" --data "$data" >/dev/null; done
for i in $(seq 10); do
  until [ "$(curl -s -o /dev/null -w '%{http_code}' -H "Host: s$i.test" "http://127.0.0.1:$port/healthz")" = 200 ]; do
    kill -0 "$server" || fail "the server ended"
    sleep 0.2
  done
done
look 10
stop_server
