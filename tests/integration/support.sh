# Shared by the integration scripts: a work folder, free ports, and everything stopped at the end.
# ENAMEL_BIN names the folder of the programs under test (default: build/release/bin).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bin=${ENAMEL_BIN:-$root/build/release/bin}
# How many times longer than a release build's a program may take: a sanitizer's take minutes for seconds.
patience=1
case $bin in */asan/* | */tsan/*) patience=5 ;; esac
work=$(mktemp -d)
pids=()
stop_all() {
  for pid in "${pids[@]:-}"; do [ -n "$pid" ] && kill -TERM "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap stop_all EXIT

# The page that servers show: the built one, or one line where it was not built. No script here asks for more of it.
if [ -f "$root/web/dist/index.html" ]; then
  page_folder=$root/web/dist
else
  page_folder=$work/page
  mkdir "$page_folder"
  echo '<!doctype html><title>Enamel</title>' >"$page_folder/index.html"
fi

fail() { echo "FAILED: $*" >&2; exit 1; }

# Two neighbouring free ports on loopback; prints the lower. Below 32768: no client gets them while a server is between two
# starts.
free_ports() {
  node -e '
    const net = require("net");
    const open = (p) => new Promise((ok) => { const s = net.createServer(); s.once("error", () => ok()); s.listen(p, "127.0.0.1", () => ok(s)); });
    (async () => {
      for (let i = 0; i < 200; ++i) {
        const p = 20000 + 2 * Math.floor(Math.random() * 6380);
        const a = await open(p), b = a && await open(p + 1);
        a?.close(); b?.close();
        if (a && b) { console.log(p); return; }
      }
      process.exit(1);
    })();'
}

# expect_failure NAME PATTERN COMMAND...: exits non-zero, says PATTERN, and does not crash.
expect_failure() {
  local name=$1 pattern=$2 rc=0
  shift 2
  timeout $((120 * patience)) "$@" >"$work/out" 2>&1 </dev/null || rc=$?
  [ $rc -ne 0 ] || { cat "$work/out"; fail "$name: expected a failure, exit code was 0"; }
  [ $rc -ne 124 ] || fail "$name: did not end within $((120 * patience)) s"
  [ $rc -lt 128 ] || { cat "$work/out"; fail "$name: crashed with signal $((rc - 128))"; }
  ! grep -qE 'Sanitizer: |runtime error: ' "$work/out" || { cat "$work/out"; fail "$name: found by a sanitizer"; }
  grep -qiE -- "$pattern" "$work/out" || { cat "$work/out"; fail "$name: message does not say /$pattern/"; }
  echo "ok: $name (exit code $rc): $(grep -iE -m1 -- "$pattern" "$work/out" | cut -c1-160)"
}

# A screen that nobody sees, for windows: DISPLAY names it. Skips the test where there is no Xvfb.
start_display() {
  command -v Xvfb >/dev/null || { echo "skipped: Xvfb is not installed"; exit 77; }
  local number
  mkfifo "$work/display"
  Xvfb -displayfd 3 -screen 0 1920x1080x24 -noreset -nolisten tcp 3<>"$work/display" >/dev/null 2>&1 &
  pids+=($!)
  read -r -t 30 number <"$work/display" || fail "Xvfb did not start"
  export DISPLAY=":$number"
}

# wait_for_log FILE PATTERN: until a line of a log has it, at most a minute. The reader ends with its shell.
wait_for_log() {
  timeout 60 bash -c 'grep -qm1 -e "$2" < <(tail -n +1 -s 0.1 --pid=$$ -F "$1" 2>/dev/null)' _ "$1" "$2" ||
    { cat "$1"; fail "$(basename "$1") did not say \"$2\" within a minute"; }
}

# add_students DATA COUNT: chair1, chair2, … in the demo's class, with the password of ENAMEL_PASSWORD: nobody works at two
# stations at once.
add_students() {
  local i
  for i in $(seq "$2"); do
    printf '%s\n' "$ENAMEL_PASSWORD" |
      "$bin/enamel-server" admin add-person --data "$1" --login "chair$i" --role student --password-stdin >/dev/null
    "$bin/enamel-server" admin add-to-cohort --data "$1" --cohort "Demo cohort" --login "chair$i" >/dev/null
  done
}

# json_of FILE NAME: one member of a JSON object.
json_of() { node -p 'JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"))[process.argv[2]]' "$1" "$2"; }

# chunks_of STATION: "recorded committed" of the newest attempt in the spool, or "0 0".
chunks_of() {
  "$bin/enamel-station" spool list --data "$1" 2>/dev/null |
    awk '/ chunks on the server/ { match($0, /[0-9]+ of [0-9]+ chunks/); split(substr($0, RSTART), n, " "); r = n[3]; c = n[1] }
         END { print r + 0, c + 0 }'
}

# newest STATION: id of the newest attempt in the spool.
newest() { "$bin/enamel-station" spool list --data "$1" | tail -n 1 | cut -d' ' -f1; }

# cut_off STATION CHUNKS COMMAND…: the command makes an attempt, and is killed once that many of its chunks are spooled.
# `attempt` is the attempt, `killed_ms` when.
cut_off() {
  local station=$1 chunks=$2 before recorded
  shift 2
  before=$(newest "$station")
  "$@" >"$work/cut.log" 2>&1 &
  local runner=$!
  pids+=("$runner")
  for _ in $(seq 3000); do
    kill -0 "$runner" 2>/dev/null || { cat "$work/cut.log"; fail "the attempt was over before it could be cut off"; }
    attempt=$(newest "$station")
    read -r recorded _ < <(chunks_of "$station")
    [ "$attempt" = "$before" ] || [ "$recorded" -lt "$chunks" ] || break
  done
  kill -KILL "$runner"
  wait "$runner" 2>/dev/null || true
  killed_ms=$(date +%s%3N)
}

# start_server DATA PORT [options]: waits until it is ready.
start_server() {
  local data=$1 port=$2
  shift 2
  : >"$work/server.log"  # an earlier server's "ready" is not this one's
  "$bin/enamel-server" serve --data "$data" --http "127.0.0.1:$port" --stations "127.0.0.1:$((port + 1))" \
    --web "$page_folder" "$@" >"$work/server.log" 2>&1 &
  server=$!
  pids+=("$server")
  for _ in $(seq 600); do
    grep -q '^ready' "$work/server.log" && return
    kill -0 "$server" 2>/dev/null || { cat "$work/server.log"; fail "server did not start"; }
    sleep 0.1
  done
  fail "server not ready within 60 s"
}
stop_server() {
  kill -TERM "$server"
  wait "$server" || fail "server ended with exit code $?; its log ends with $(tail -n 5 "$work/server.log")"
}
kill_server() {
  kill -KILL "$server" 2>/dev/null || true
  wait "$server" 2>/dev/null || true
}
