# A recording under way while something happens to the database: sourced after integration/support.sh, with $data,
# $station, $port and $work/seed of `seed-demo`. Who sources it defines `chunks NAME`: how many chunks that PostgreSQL
# server has.

# start_slow_cut NAME: enrols a station of that name and lets it cut, its uplink slow. Its process is $cutting.
start_slow_cut() {
  "$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" \
    --code "$("$bin/enamel-server" admin enrol-code --data "$data")" --name "$1" >/dev/null
  "$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet \
    --exercise "$(json_of "$work/seed" exercise)" --user instructor --operator dentist --as-reference --uplink-kbit 800 \
    --json "$work/cut.json" >"$work/run.log" 2>&1 &
  cutting=$!
  pids+=("$cutting")
}
# until_more_than NAME COUNT
until_more_than() {
  local deadline=$((SECONDS + 120))
  until [ "$(chunks "$1")" -gt "$2" ]; do
    kill -0 "$cutting" 2>/dev/null || { cat "$work/run.log"; fail "the attempt ended too early"; }
    [ $SECONDS -lt $deadline ] || { tail -n 20 "$work"/*.log; fail "nothing came in for 120 s"; }
  done
}
