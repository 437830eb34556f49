#!/usr/bin/env bash
# Everything that ends the window in the middle of an attempt leaves the attempt resumable and uses nothing up: SIGTERM,
# SIGINT, SIGQUIT, SIGTSTP and SIGHUP (a stop, a terminal's or a session's end), the end of the program that started it,
# of the display, SIGKILL, and a stop while the display hangs, which SIGKILL ends; while cutting, paused, handing in and with a full disk; an exam with one attempt, and graded work.
# In ./check three of these; all with ENAMEL_FULL=1.
. "$(dirname "$0")/support.sh"
command -v Xvfb >/dev/null || { echo "skipped: Xvfb is not installed"; exit 77; }
# For a full disk of its own, where one may be mounted.
if [ "${ENAMEL_IN_NAMESPACE:-}" != 1 ] && unshare -m true 2>/dev/null; then
  ENAMEL_IN_NAMESPACE=1 exec unshare -m "$0" "$@"
fi
export LC_ALL=C.UTF-8  # the window speaks English
station=$work/station server_data=$work/server
mkdir "$station"
may_fill=no
[ "${ENAMEL_IN_NAMESPACE:-}" != 1 ] || ! mount -t tmpfs -o size=64m none "$station" 2>/dev/null || may_fill=yes
trap 'umount -l "$station" 2>/dev/null || true; stop_all' EXIT

"$bin/enamel-server" init --data "$server_data" >/dev/null
"$bin/enamel-server" seed-demo --data "$server_data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
port=$(free_ports)
start_server "$server_data" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name "Chair 7" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$server_data")" >/dev/null
ENAMEL_PASSWORD=enamel-demo-instructor "$bin/enamel-station" run --data "$station" --exercise "$exercise" --quiet \
  --profile phantom_desktop --user instructor --operator dentist --lockstep --as-reference --json "$work/reference" >/dev/null
reference=$(json_of "$work/reference" attempt_id)
"$bin/enamel-server" report --data "$server_data" --attempt "$reference" --wait $((120 * patience)) >/dev/null
"$bin/enamel-server" admin mark-reference --data "$server_data" --attempt "$reference" --dentist "Simulated dentist" --consent >/dev/null
"$bin/enamel-server" admin assign-exercise --data "$server_data" --exercise "$exercise" --cohort "Demo cohort" --attempts 1 \
  --exam --hands any >/dev/null
export ENAMEL_PASSWORD=kettle-orbit-plum

# display: an Xvfb of its own; `screen` is its process.
display() {
  local number
  rm -f "$work/display"
  mkfifo "$work/display"
  Xvfb -displayfd 3 -screen 0 1024x768x24 -noreset -nolisten tcp 3<>"$work/display" >/dev/null 2>&1 &
  screen=$!
  pids+=("$screen")
  read -r -t 30 number <"$work/display" || fail "Xvfb did not start"
  export DISPLAY=":$number"
}
# is_at FILE: the script has come to where it writes this picture.
is_at() {
  for _ in $(seq 1200); do
    [ ! -s "$1" ] || return 0
    kill -0 "$window" 2>/dev/null || { cat "$work/window.log"; fail "$name: the window ended by itself"; }
    sleep 0.05
  done
  cat "$work/window.log"
  fail "$name: the window did not get there"
}
state_of() { "$bin/enamel-station" spool list --data "$station" | grep "^$1" || true; }

# script STATE: from the sign-in to the state; `begin` is how the attempt begins.
script() {
  cat <<TXT
page sign-in
type $student
key Tab
type $ENAMEL_PASSWORD
key Enter
page exercises
$begin
page running
frames 10
wheel 2
frames 10
hold Space
wheel 24
move 2 0 30
removed 0.05
TXT
  case $1 in
    cutting | full) ;;
    paused) printf 'let Space\nkey Escape\npage paused\n' ;;
    handing-in) printf 'let Space\nkey F\npage finish\nclick Hand in\npage hand-in\nsee cannot be reached\n' ;;
  esac
  printf 'picture %s\nuntil %s\n' "$work/there.png" "$work/never"
}

# stop WAY STATE KIND
stop() {
  local way=$1 state=$2 kind=$3 rc=0 id line
  name="$way, $state, $kind"
  # Each stop has a student of its own, who sees the exam first and then the demo's graded exercise.
  begin=$'click Class I\npage exercise\nsee This is an exam\nsee Bur:\nclick Start'
  [ "$kind" = exam ] || begin=$'click Class I #2\npage exercise\nsee Bur:\nclick Start'
  rm -f "$work/there.png"
  display
  script "$state" >"$work/script.txt"
  before=$(newest "$station")
  # A parent of its own, which only waits.
  bash -c '"$0" "$@" & echo $! >"$WINDOW_PID"; wait' "$bin/enamel-station" open --data "$station" --window 800x600 --no-sound --no-mouth \
    --script "$work/script.txt" >"$work/window.log" 2>&1 &
  parent=$!
  pids+=("$parent")
  window=""
  for _ in $(seq 200); do [ -s "$WINDOW_PID" ] && window=$(cat "$WINDOW_PID") && break; sleep 0.05; done
  pids+=("$window")
  if [ "$state" = handing-in ]; then
    # Once it cuts, so that the attempt could begin.
    for _ in $(seq 1200); do [ "$(newest "$station")" = "$before" ] || break; sleep 0.05; done
    stop_server
  fi
  is_at "$work/there.png"
  [ "$state" != full ] || { dd if=/dev/zero of="$station/filler" bs=64k 2>/dev/null || true; sleep 1; }
  case $way in
    TERM | INT | QUIT | TSTP | HUP | KILL) kill "-$way" "$window" ;;
    parent) kill -KILL "$parent" ;;
    display) kill -KILL "$screen" ;;
    hung)
      kill -STOP "$screen"
      kill -TERM "$window"
      # With a full disk the last samples wait for space until the kill.
      if [ "$state" = cutting ] || [ "$state" = paused ]; then
        for _ in $(seq 600); do grep -q "is left and can be resumed" "$work/window.log" && break; sleep 0.05; done
        grep -q "is left and can be resumed" "$work/window.log" || { cat "$work/window.log"; fail "$name: it goes on"; }
      fi
      kill -KILL "$window"
      ;;
  esac
  for _ in $(seq 600); do kill -0 "$window" 2>/dev/null || break; sleep 0.05; done
  kill -0 "$window" 2>/dev/null && fail "$name: the window went on for 30 s"
  wait "$parent" 2>/dev/null || true
  kill -KILL "$screen" 2>/dev/null || true
  wait "$screen" 2>/dev/null || true
  rm -f "$station/filler"
  [ "$state" != handing-in ] || start_server "$server_data" "$port"
  id=$(newest "$station")
  [ "$id" != "$before" ] || fail "$name: no attempt was begun"
  line=$(state_of "$id")
  if [ "$state" = handing-in ]; then
    ! grep -q unfinished <<<"$line" || fail "$name: what was handed in has no end: $line"
    "$bin/enamel-station" upload --data "$station" >/dev/null || fail "$name: it cannot be sent"
  else
    grep -q unfinished <<<"$line" || { cat "$work/window.log"; fail "$name: it is not resumable: $line"; }
    "$bin/enamel-station" spool verify --data "$station" >"$work/verify" ||
      { cat "$work/verify"; fail "$name: the spool does not verify"; }
    [ "$("$bin/enamel-server" admin list-attempts --data "$server_data" | grep "$id" | grep -c recording)" -eq 1 ] ||
      { "$bin/enamel-server" admin list-attempts --data "$server_data"; fail "$name: the server counts it as ended"; }
    "$bin/enamel-station" spool close "$id" --data "$station" >/dev/null
    "$bin/enamel-station" upload --data "$station" >/dev/null || fail "$name: it cannot be sent"
  fi
  echo "ok: $name"
}
export WINDOW_PID=$work/window.pid

ways=(TERM INT QUIT TSTP HUP parent display hung KILL)
states=(cutting paused handing-in)
[ $may_fill = no ] || states+=(full)
kinds=(exam graded)
# In ./check three of them, else all; exams and graded work in turn.
stops=("TERM cutting exam" "parent ${states[-1]} graded" "display paused exam")
if [ -n "${ENAMEL_FULL:-}" ]; then
  stops=()
  for way in "${ways[@]}"; do
    for state in "${states[@]}"; do stops+=("$way $state ${kinds[${#stops[@]} % 2]}"); done
  done
fi
add_students "$server_data" "${#stops[@]}"
for i in "${!stops[@]}"; do
  student=chair$((i + 1))
  rm -f "$WINDOW_PID"
  # shellcheck disable=SC2086
  stop ${stops[i]}
done
