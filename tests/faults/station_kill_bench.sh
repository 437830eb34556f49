#!/usr/bin/env bash
# station_kill_bench.sh [KILLS [STATIONS]]: stations (2 to 6 at once, one server) are killed (kill -9) KILLS times in all
# (6, or 24 with ENAMEL_FULL=1) at random moments, from the program's start to some seconds into an attempt. What was cut
# off is resumed, and cut off again; after eight cuts it is closed as it is. Every third station runs in lockstep, as fast
# as the machine can: there most kills fall into a write to the spool. The others tick at 1 kHz, as at the chair: there
# the tail is time, from the last tick that is durable to the kill.
#   While a station runs, a second process asks its spool what is recorded: those ticks are "reported". After each kill
# they are there. In the end the spools are whole (chain, signatures, seals), every attempt is at the server, sealed, with
# as many ticks as were recorded, which includes all that were ever reported; what was resumed has a declared gap, at 1 kHz
# no shorter than the tails that the kills cut off; and the attempt that was resumed most often re-runs to its witness.
#   tests/faults/station_kill_bench.sh 1000      what the issue asks for; five minutes.  ENAMEL_SEED repeats the choices.
. "$(dirname "$0")/../integration/support.sh"
kills=${1:-}
[ -n "$kills" ] || { [ "${ENAMEL_FULL:-}" = 1 ] && kills=24 || kills=6; }
stations=${2:-$((kills >= 100 ? 6 : kills >= 3 ? 3 : kills))}
seed=${ENAMEL_SEED:-$((SRANDOM % 100000))}
enamel_server=$bin/enamel-server enamel_station=$bin/enamel-station
data=$work/server
port=$(free_ports)
export ENAMEL_PASSWORD=enamel-demo-student1
max_cuts=8
echo "seed $seed: $kills kills of $stations stations"

now_ms() { local us=${EPOCHREALTIME/[.,]/}; echo "${us:0:-3}"; }
random_ms() { echo $(((RANDOM * 32768 + RANDOM) % $1)); }
pause_ms() { sleep "$(printf '%d.%03d' $(($1 / 1000)) $(($1 % 1000)))"; }
# number_of OBJECT NAME: a member of a flat JSON object, or 0.
number_of() { [[ $1 =~ \"$2\":([0-9]+) ]] && echo "${BASH_REMATCH[1]}" || echo 0; }
# text_of OBJECT NAME: likewise, or nothing.
text_of() { [[ $1 =~ \"$2\":\"([^\"]+) ]] && echo "${BASH_REMATCH[1]}" || true; }
# look STATION [ID]: facts of the newest attempt, or of that one, as a JSON object; empty: none.
look() {
  local all
  "$enamel_station" spool list --json "$1.list" --data "$1" >/dev/null
  all=$(<"$1.list")
  # Why a recording waits is an object of its own.
  while [[ $all =~ \"waits\":\{[^{}]*\},? ]]; do all=${all/"${BASH_REMATCH[0]}"/}; done
  if [ -n "${2:-}" ]; then
    [[ $all =~ \{[^{}]*\"$2\"[^{}]*\} ]] && echo "${BASH_REMATCH[0]}" || true
  else
    [[ $all == *'"attempts":[]'* ]] || echo "{${all##*\{}"
  fi
}

# Station INDEX is killed COUNT times. A line per kill: attempt, kind, ticks reported, ms of the last durable tick and of
# the kill (0: nothing was being recorded), whether it was resumed.
torture() {
  local i=$1 count=$2 station=$work/station$1 kind=clock span=3500 how run=() before="" facts id seen cuts=0 reported rc last ms kill=0 runner=""
  RANDOM=$((seed + i))
  trap '[ -z "$runner" ] || kill -KILL "$runner" 2>/dev/null || true' EXIT
  trap 'exit 1' TERM
  [ $((i % 3)) -ne 0 ] || kind=lockstep span=2500 run=(--lockstep)
  while [ $((kill += 1)) -le "$count" ]; do
    how=(--exercise "$exercise" --profile phantom_desktop)
    [ -z "$before" ] || how=(--resume "$before")
    "$enamel_station" run --data "$station" --quiet --user "chair$i" --operator student "${run[@]}" "${how[@]}" >"$work/run$i" 2>&1 &
    runner=$!
    pause_ms "$(random_ms $span)"
    facts=$(look "$station")
    seen=$(text_of "$facts" attempt_id)
    reported=$(number_of "$facts" ticks)
    # The last one falls into a recording, however slow the machine.
    for _ in $(seq 600); do
      [ "$kill" -eq "$count" ] && [ "$reported" -eq 0 ] && kill -0 "$runner" 2>/dev/null || break
      sleep 0.2
      facts=$(look "$station")
      seen=$(text_of "$facts" attempt_id) reported=$(number_of "$facts" ticks)
    done
    pause_ms "$(random_ms 200)"
    kill -KILL "$runner" 2>/dev/null || true
    ms=${EPOCHREALTIME/[.,]/} rc=0  # no $(...) here: it would tell of the kill
    wait "$runner" 2>/dev/null || rc=$?
    runner="" ms=${ms:0:-3}
    # All of them signed in at once: no kill, and once more.
    if [ $rc -eq 1 ] && grep -q 'too many sign-ins at once' "$work/run$i"; then
      kill=$((kill - 1))
      pause_ms "$(random_ms 2000)"
      continue
    fi
    [ $rc -eq 0 ] || [ $rc -eq 3 ] || [ $rc -eq 137 ] || { cat "$work/run$i"; fail "station $i ended with exit code $rc"; }
    [ -z "$seen" ] || [ "$(number_of "$(look "$station" "$seen")" ticks)" -ge "$reported" ] || fail "station $i: $seen had $reported ticks, now $(look "$station" "$seen")"
    facts=$(look "$station")
    id=$(text_of "$facts" attempt_id)
    [ -n "$id" ] || { echo "- $kind 0 0 0 0" >>"$work/kills$i"; continue; }
    last=$(number_of "$facts" last_spooled_unix_ms)
    [ "$(text_of "$facts" state)" = unfinished ] && [ $rc -eq 137 ] || ms=0
    [ "$seen" = "$id" ] || reported=0
    echo "$id $kind $reported $last $ms $([ "$before" = "$id" ] && echo 1 || echo 0)" >>"$work/kills$i"
    [ "$before" = "$id" ] && cuts=$((cuts + 1)) || cuts=1
    before=""
    [ "$(text_of "$facts" state)" != unfinished ] || before=$id
    if [ -n "$before" ] && [ "$last" -gt 0 ] && [ $cuts -ge $max_cuts ]; then
      "$enamel_station" spool close "$id" --data "$station" >/dev/null
      before=""
    fi
  done
  [ -z "$before" ] || [ "$last" -eq 0 ] || "$enamel_station" spool close "$before" --data "$station" >/dev/null
}

"$enamel_server" init --data "$data" >/dev/null
"$enamel_server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
add_students "$data" "$stations"
start_server "$data" "$port" --job-threads 0
for i in $(seq "$stations"); do
  "$enamel_station" enrol --data "$work/station$i" --server "127.0.0.1:$((port + 1))" \
    --code "$("$enamel_server" admin enrol-code --data "$data")" --name "bench $i" >/dev/null
done
begin=$(now_ms)
workers=()
for i in $(seq "$stations"); do
  torture "$i" $((kills / stations + (i <= kills % stations ? 1 : 0))) &
  workers+=("$!")
  pids+=("$!")
done
done_so_far() { cat "$work"/kills* 2>/dev/null | wc -l; }
told=0
while [ -n "$(jobs -rp | grep -vx "$server")" ]; do
  sleep 1
  [ $(($(done_so_far) - told)) -lt 50 ] || { told=$(done_so_far); echo "  $told kills, $((($(now_ms) - begin) / 1000)) s"; }
done
for worker in "${workers[@]}"; do wait "$worker" || fail "a station did not come through: see above"; done
took_s=$((($(now_ms) - begin) / 1000))

: >"$work/spools"
for i in $(seq "$stations"); do
  "$enamel_station" spool verify --data "$work/station$i" >"$work/verify" || { cat "$work/verify"; fail "the spool of station $i is damaged"; }
  "$enamel_station" upload --data "$work/station$i" >"$work/upload" 2>&1 || { cat "$work/upload"; fail "station $i could not upload"; }
  "$enamel_station" spool list --json "$work/listed" --data "$work/station$i" >/dev/null
  cat "$work/listed" >>"$work/spools"
done
cat "$work"/kills* >"$work/kills"
"$enamel_server" admin list-attempts --data "$data" --limit 1000000 >"$work/list"
node -e '
  const fs = require("fs"), [, spools, list, log, took] = process.argv;
  const die = (why) => { console.error("FAILED: " + why); process.exit(1); };
  const lines = (file) => fs.readFileSync(file, "utf8").split("\n").filter((l) => l);
  const server = new Map();
  for (const l of lines(list)) {
    const id = l.split(" ")[0];
    if (server.has(id)) die(`attempt ${id} is at the server twice`);
    server.set(id, +(l.match(/(\d+) ticks/) ?? [0, -1])[1]);
  }
  const kills = lines(log).map((l) => { const [id, kind, ticks, last, ms, resumed] = l.split(" "); return { id, kind, ticks: +ticks, last: +last, ms: +ms, resumed: +resumed }; });
  const attempts = lines(spools).flatMap((l) => JSON.parse(l).attempts).filter((a) => a.chunks > 0);
  let ticks = 0, resumes = 0, gaps = 0, reported = 0, longest = 0, tails = [];
  for (const a of attempts) {
    if (a.state !== "uploaded") die(`attempt ${a.attempt_id} is ${a.state}`);
    if (server.get(a.attempt_id) !== a.ticks) die(`attempt ${a.attempt_id}: ${a.ticks} ticks here, ${server.get(a.attempt_id)} at the server`);
    const mine = kills.filter((k) => k.id === a.attempt_id);
    const seen = Math.max(0, ...mine.map((k) => k.ticks));
    if (seen > server.get(a.attempt_id)) die(`attempt ${a.attempt_id}: ${seen} ticks were reported, ${server.get(a.attempt_id)} are at the server`);
    // Of the kills since one tick was durable the last counts; none after it: nothing to declare.
    const cut = new Map();
    for (const k of mine) if (k.ms > 0 && k.last > 0) cut.set(k.last, Math.max(cut.get(k.last) ?? 0, k.ms - k.last));
    const first = new Map();
    for (const k of mine) if (k.ms > 0 && k.last > 0 && !first.has(k.last)) first.set(k.last, k.ms - k.last);
    const gone_on = [...cut].filter(([last]) => last < a.last_spooled_unix_ms);
    if (gone_on.length > 0 && a.gap_ticks === 0) die(`attempt ${a.attempt_id} went on ${gone_on.length} times without a declared gap`);
    if (mine[0]?.kind === "clock") {
      const due = gone_on.reduce((sum, [, tail]) => sum + tail, 0);
      if (a.gap_ticks < due) die(`attempt ${a.attempt_id}: the kills cut off ${due} ms, declared are ${a.gap_ticks}`);
      tails.push(...first.values());
      gaps += a.gap_ticks;
    }
    ticks += a.ticks; resumes += a.resumed; reported += seen;
  }
  for (const k of kills) if (k.ticks > 0 && !server.has(k.id)) die(`attempt ${k.id} had ${k.ticks} ticks and is not at the server`);
  if (attempts.length === 0) die("nothing was recorded");
  tails.sort((a, b) => a - b);
  const at = (share) => tails.length === 0 ? 0 : tails[Math.min(tails.length - 1, Math.floor(share * tails.length))];
  const while_recording = kills.filter((k) => k.ms > 0).length;
  console.log(`${kills.length} kills in ${took} s, ${while_recording} of them cut an attempt off, the others fell before it or after its end`);
  console.log(`${attempts.length} attempts, taken up again ${resumes} times: ${ticks} ticks, of which ${reported} were seen in the spool before a kill; at the server once: all; 0 lost, 0 doubled`);
  console.log(`tail at 1 kHz, from the last durable tick to the kill: median ${at(0.5)} ms, p99 ${at(0.99)} ms, longest ${at(1)} ms (${tails.length} kills); declared as gaps: ${gaps} ticks, in no attempt less than its tails`);
' "$work/spools" "$work/list" "$work/kills" "$took_s"
# What was resumed most often re-runs to its witness.
read -r i most < <(node -e '
  const all = require("fs").readFileSync(process.argv[1], "utf8").split("\n").filter((l) => l).flatMap((l, i) => JSON.parse(l).attempts.map((a) => ({ ...a, i: i + 1 })));
  const most = all.filter((a) => a.chunks > 0).sort((a, b) => b.resumed - a.resumed)[0];
  console.log(most.i, most.attempt_id);
' "$work/spools")
"$enamel_station" spool export --data "$work/station$i" "$most" --out "$work/most.trace" >/dev/null
"$enamel_station" replay --data "$work/station$i" "$work/most.trace" --no-keyframes | tail -n 3
"$enamel_server" verify --data "$data" | tail -n 1
stop_server
