#!/usr/bin/env bash
# A server whose machine's clock is wrong, by faketime: its times are the database's, and from 5 s on /readyz warns. Nobody
# can say which of two clocks is wrong, so it goes on. with_postgres.sh starts PostgreSQL.
. "$(dirname "$0")/../integration/support.sh"
case $bin in */asan/* | */tsan/*)
  echo "skipped: faketime is loaded before a program, and so must a sanitizer's library be"
  exit 77
  ;;
esac
for program in faketime curl; do
  command -v $program >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
data=$work/server
port=$(free_ports)
"$bin/enamel-server" init --data "$data" --database "$ENAMEL_POSTGRES" --schema clock
rows() { PGOPTIONS="-c search_path=clock" psql -X -A -t -d "$ENAMEL_POSTGRES" -c "$1"; }
clock() { rows "SELECT floor(extract(epoch FROM clock_timestamp()) * 1000)::bigint"; }
# off SECONDS COMMAND...: with the machine's clock off by so much. What measures how much time goes by is right.
off() { FAKETIME_DONT_FAKE_MONOTONIC=1 faketime -f "$(printf %+d "$1")s" "${@:2}"; }
# health "STATUS WORD": what /readyz says. A server that is ready has looked at the database's clock.
health() {
  local found
  found=$(curl -s -o "$work/health" -w '%{http_code}' "http://127.0.0.1:$port/readyz")
  [ "$found $(json_of "$work/health" status)" = "$1" ] || fail "expected /readyz $1, found $found: $(cat "$work/health")"
}
serve() {
  off "$1" "$bin/enamel-server" serve --data "$data" --http "127.0.0.1:$port" --stations "127.0.0.1:$((port + 1))" \
    --web "$page_folder" >"$work/server.log" 2>&1 &
  pids+=($!)
  wait_for_log "$work/server.log" '^ready'
}
# faketime ends after the server that it started, when it is left alone itself.
end() {
  pkill -f "^$bin/enamel-server serve --data $data "
  wait "${pids[-1]}" || true
}

for seconds in -3600 3600; do
  before=$(clock)
  off "$seconds" "$bin/enamel-server" admin add-cohort --data "$data" --name "off by $seconds" >/dev/null
  after=$(clock)
  at=$(rows "SELECT at_ms FROM audit WHERE action LIKE 'cohort.%' ORDER BY id DESC LIMIT 1")
  # Within what asking for the time takes.
  [ $((at + 1000)) -ge "$before" ] && [ $((at - 1000)) -le "$after" ] || fail "expected a time from $before to $after, found $at"
done
echo "ok: times are the database's, an hour before and after"

serve -3
health "200 ok"
end
serve 8
health "200 degraded"
wait_for_log "$work/server.log" 'clock is [78] s ahead of the database server'
end
serve -8
health "200 degraded"
grep -q 'behind the database server' "$work/health" || fail "expected that the clock is behind, found $(cat "$work/health")"
end
echo "ok: 3 s are borne, 8 s are told"
