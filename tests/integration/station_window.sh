#!/usr/bin/env bash
# A student at the station's window, played by a script without a screen: wrong password, sign in, choose, cut with the
# mouse, pause, finish, see the score, try again, sign out; a password that was for one use; an attempt that was cut off
# goes on, another is handed in as it is; one is kept for later and made without the server; the server goes away at
# sign-in and in the middle; the spool is damaged. ENAMEL_PICTURES=FOLDER keeps the pictures of every
# page.
. "$(dirname "$0")/support.sh"
start_display
pictures=${ENAMEL_PICTURES:-$work/pictures}
mkdir -p "$pictures"
rm -f "$pictures"/[0-9]*.png  # of an earlier run: the test waits for some
station="$work/station"
export LC_ALL=C.UTF-8  # it reads English

"$bin/enamel-server" init --data "$work/server" >/dev/null
"$bin/enamel-server" seed-demo --data "$work/server" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
port=$(free_ports)
start_server "$work/server" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name "Chair 7" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$work/server")" >/dev/null
ENAMEL_PASSWORD=enamel-demo-instructor "$bin/enamel-station" run --data "$station" --exercise "$exercise" --quiet \
  --profile phantom_desktop --user instructor --operator dentist --lockstep --as-reference --json "$work/reference" >/dev/null
reference=$(json_of "$work/reference" attempt_id)
"$bin/enamel-server" report --data "$work/server" --attempt "$reference" --wait $((120 * patience)) >/dev/null
"$bin/enamel-server" admin mark-reference --data "$work/server" --attempt "$reference" --dentist "Simulated dentist" --consent >/dev/null

# play NAME [SIZE [options]]: a script on standard input, at a window of 1280 x 720 or that size. PICTURES and WORK stand for
# the folders.
# `sign in as NAME` stands for what a student types on the first page.
play() {
  sed "s|PICTURES|$pictures|; s|WORK|$work|
    s|^sign in as \(.*\)|page sign-in\ntype \1\nkey Tab\ntype enamel-demo-\1\nkey Enter\npage exercises|" \
    >"$work/$1.txt"
  timeout $((900 * patience)) "$bin/enamel-station" open --data "$station" --window "${2:-1280x720}" --no-sound --simulated --script "$work/$1.txt" "${@:3}" ||
    { tail -n 20 "$work/server.log"; fail "the script $1 did not get through"; }
}
# Waits until a script has come to where it writes this picture.
await_picture() {
  for _ in $(seq 600); do
    [ ! -s "$pictures/$1.png" ] || return 0
    sleep 0.1
  done
  fail "no picture of $1 within a minute"
}
attempts() { "$bin/enamel-station" spool list --data "$station" | grep -c ' chunks on the server' || true; }

before=$(attempts)
play student <<'EOF'
page sign-in
picture PICTURES/1-sign-in.png
type student1
key Tab
type wrong
key Enter
see password
picture PICTURES/2-wrong-password.png
# The password's field still has the focus.
type enamel-demo-student1
key Enter
page exercises
see Tooth 46, occlusal
see Graded: any number of attempts
frames 2
picture PICTURES/3-exercises.png
key Enter
page exercise
see Bur:
frames 3
picture PICTURES/4-exercise.png
# Tried first, on a block: nothing of it is an attempt.
click Try the device
page warm-up
frames 10
wheel 6
hold Space
wheel 6
frames 30
picture PICTURES/4-warm-up.png
let Space
key Escape
page exercise
see Device tried for
# The focus is at Start.
key Enter
page running
frames 10
# Down to the tooth, then across it with the bur turning.
wheel 2
frames 30
picture PICTURES/5-running.png
# The other hand's mirror: the bur stays where it is.
key M
hold Control
move -6 2 5
let Control
frames 2
picture PICTURES/5-mirror.png
key M
hold Space
wheel 24
frames 20
move 2 0 30
removed 0.3
move 0 -2 20
wheel 4
move -2 0 30
removed 0.8
key F1
frames 30
picture PICTURES/6-cutting.png
key F1
let Space
key Escape
page paused
frames 2
picture PICTURES/7-paused.png
key Escape
page running
key F
page finish
frames 2
picture PICTURES/8-finish.png
# The pedal chooses nothing here, and going on comes first.
key Space
frames 5
page finish
key Enter
page running
key F
page finish
click Hand in
page result
see Handed in
frames 3
picture PICTURES/9-result.png
click Try again
page exercise
see Bur:
key Escape
page exercises
key Escape
page sign-in
key Escape
page close
# Staying comes first.
key Enter
page sign-in
quit
EOF
# An instructor sees the score at once, and may make the cut the reference.
play instructor 1920x1080 <<'EOF'
page sign-in
type instructor
key Tab
type enamel-demo-instructor
key Enter
page exercises
key Enter
page exercise
see Bur:
frames 3
picture PICTURES/10-instructor-exercise.png
click Start
page running
wheel 2
frames 20
hold Left
wheel 20
frames 20
move 3 0 30
removed 0.4
frames 20
picture PICTURES/11-zones.png
let Left
hold Right
move 24 6 12
picture PICTURES/11-turning.png
let Right
frames 10
picture PICTURES/11-turned.png
key F
page finish
click Hand in
page result
see of 100 points
see You made
see Outline
see Before
see After
see Target
see Deviation
# The reference cut was this person's too.
see Your points in 2 attempts
frames 3
picture PICTURES/12-score.png
# Where most was lost, on the tooth; and back to the same result.
click Show me
page loss
see place in the ring
see [Back]
frames 12
picture PICTURES/12-loss.png
key Escape
page result
see of 100 points
# The same tooth once more, without a recording.
click Continue this cut
page practice
see nothing is recorded
frames 20
picture PICTURES/12-practice.png
key Escape
page practice-paused
click Back to the result
page result
see of 100 points
click Reference
page reference
click The dentist agrees
frames 2
picture PICTURES/13-reference.png
click Make it the reference
# That too little was cut, or, on a machine with other work, that ticks came late.
see cannot be the reference
frames 2
picture PICTURES/38-reference-refused.png
click Reason for going ahead
type A short cut for a test
click Do it anyway
page result
see Is the reference
quit
EOF
[ "$(attempts)" -eq $((before + 2)) ] || fail "expected two attempts more in the spool"
"$bin/enamel-station" spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "the spool does not verify"; }
once=$("$bin/enamel-server" admin add-person --data "$work/server" --login once --role student | sed -n 's/^password.*: //p')
[ -n "$once" ] || fail "no password for one use was printed"
play once <<EOF
page sign-in
type once
key Tab
type $once
key Enter
page first-password
type kettle orbit plum fence
key Enter
type kettle orbit plum
key Enter
see do not match
frames 2
picture PICTURES/14-once.png
type kettle orbit plum fence
key Enter
type kettle orbit plum fence
key Enter
page exercises
key Escape
page sign-in
type once
key Tab
type kettle orbit plum fence
key Enter
page exercises
quit
EOF

# The server goes away in the middle of an attempt, and comes back while it is handed in.
play away <<'EOF' &
sign in as student1
click Class I
page exercise
see Bur:
click Start
page running
wheel 2
hold Space
wheel 20
frames 20
picture PICTURES/26-before-away.png
until WORK/away
frames 40
picture PICTURES/27-away.png
let Space
key F
page finish
click Hand in
page hand-in
see The server cannot be reached
see [Try again now]
frames 2
picture PICTURES/28-hand-in-away.png
until WORK/back
page sign-in
see Sign in again to see the result
frames 2
picture PICTURES/29-back.png
type student1
key Tab
type enamel-demo-student1
key Enter
page result
see Handed in
click Exercises
page exercises
see Result: Class I
frames 2
picture PICTURES/33-results.png
click Result: Class I #2
page result
see Handed in
click Sign out
page sign-in
quit
EOF
player=$!
pids+=("$player")
await_picture 26-before-away
stop_server
touch "$work/away"
await_picture 28-hand-in-away
start_server "$work/server" "$port"
touch "$work/back"
wait "$player" || fail "the attempt during which the server went away"
stop_server
play no-server <<'EOF'
page sign-in
type student1
key Tab
type enamel-demo-student1
key Enter
see The server is away
frames 2
picture PICTURES/30-no-server.png
key F1
frames 60
picture PICTURES/34-panel.png
quit
EOF
start_server "$work/server" "$port"

# cut_off OPTIONS: an attempt of student1 whose program is killed in the middle.
cut_off() {
  local before chunks
  before=$(attempts)
  ENAMEL_PASSWORD=enamel-demo-student1 ENAMEL_PIN=804217 "$bin/enamel-station" run --data "$station" --lockstep --quiet \
    --operator student "$@" >"$work/cut.log" 2>&1 &
  local runner=$!
  pids+=("$runner")
  for _ in $(seq 3000); do
    kill -0 "$runner" 2>/dev/null || { cat "$work/cut.log"; fail "the attempt was over before it could be cut off"; }
    [ "$(attempts)" -gt "$before" ] || continue  # until then the newest is an earlier one
    read -r chunks _ < <(chunks_of "$station")
    [ "$chunks" -lt 20 ] || break
  done
  kill -KILL "$runner"
  wait "$runner" 2>/dev/null || true
}
chosen=(--user student1 --exercise "$exercise" --profile phantom_desktop)
cut_off "${chosen[@]}"
cut_off "${chosen[@]}"
play cut-off <<'EOF'
sign in as student1
see Interrupted:
frames 2
picture PICTURES/15-cut-off.png
key Enter
page cut-off
frames 2
picture PICTURES/16-go-on.png
click Continue
page exercise
see Simulated: student
frames 3
picture PICTURES/17-resumed.png
click Continue cutting
page running
frames 20
picture PICTURES/18-resumed-running.png
key F
page finish
click Hand in
page result
see Handed in
click Exercises
page exercises
see Interrupted:
key Enter
page cut-off
click Hand in
page exercises
frames 20
click Class I
page exercise
see Bur:
click Keep for later
page reserve
type 123456
key Enter
type 123456
key Enter
see The digits of this PIN count up or down
frames 2
picture PICTURES/19-reserve.png
click Cancel
page exercise
click Keep for later
page reserve
type 804217
key Enter
type 804217
key Enter
page exercise
see Kept for 12 hours
frames 2
picture PICTURES/20-kept.png
click Back
page exercises
click Sign out
page sign-in
see Without the server
quit
EOF
# Beside the one that the window kept.
ENAMEL_PASSWORD=enamel-demo-student1 ENAMEL_PIN=804217 "$bin/enamel-station" reserve --data "$station" "${chosen[@]}" >/dev/null
stop_server
play offline <<'EOF'
page sign-in
click Without the server
page reserved
frames 2
picture PICTURES/21-reserved.png
key Enter
page pin
type 804218
key Enter
see Wrong PIN
type 804217
key Enter
page exercise
see Bur:
frames 2
picture PICTURES/22-offline-exercise.png
click Start
page running
frames 20
key F
page finish
click Hand in
page hand-in
see The server cannot be reached
click Do not wait
page sign-in
see safe here
frames 2
picture PICTURES/23-safe.png
quit
EOF
cut_off --reserved "$("$bin/enamel-station" reserve --data "$station" | grep -v begun | cut -d' ' -f1)"
play offline-cut-off <<'EOF'
page sign-in
click Without the server
page reserved
see CONTINUE
key Enter
page pin
type 804217
key Enter
page exercise
see Simulated: student
click Continue cutting
page running
frames 20
key F
page finish
click Hand in
page hand-in
see The server cannot be reached
click Do not wait
page sign-in
see safe here
quit
EOF
start_server "$work/server" "$port"
"$bin/enamel-station" upload --data "$station" >/dev/null
"$bin/enamel-station" upload --data "$station" | grep -q "nothing to upload" || fail "the attempt made without the server is not on it"
"$bin/enamel-station" spool list --data "$station" >"$work/list"
! grep -q unfinished "$work/list" || { cat "$work/list"; fail "an attempt that was cut off is still open"; }
"$bin/enamel-station" spool verify --data "$station" >"$work/verify" || { cat "$work/verify"; fail "the spool does not verify"; }
# A damaged spool: the window says so, and opens once somebody has saved what is in it.
cp -r "$station" "$work/broken"
rm -f "$work"/broken/spool.sqlite-*
printf 'Z%.0s' $(seq 100) | dd of="$work/broken/spool.sqlite" conv=notrunc status=none
station="$work/broken" play trouble <<'EOF' &
page trouble
see is damaged
frames 2
picture PICTURES/35-trouble.png
key F1
frames 30
picture PICTURES/36-trouble-panel.png
key F1
click Try again
page trouble
see is damaged
frames 2
picture PICTURES/37-trouble-still.png
until WORK/mended
click Try again
page sign-in
frames 2
quit
EOF
player=$!
pids+=("$player")
await_picture 37-trouble-still
"$bin/enamel-station" spool salvage --data "$work/broken" --out "$work/broken/saved" >/dev/null
mv "$work/broken/spool.sqlite" "$work/broken/damaged.sqlite"
rm -f "$work"/broken/spool.sqlite-*
mv "$work/broken/saved/spool.sqlite" "$work/broken/spool.sqlite"
touch "$work/mended"
wait "$player" || fail "the window over a damaged spool"
for n in 1-sign-in 2-wrong-password 3-exercises 4-exercise 5-running 6-cutting 7-paused 8-finish 9-result 10-instructor-exercise \
  11-zones 12-score 12-loss 12-practice 13-reference 14-once 15-cut-off 16-go-on 17-resumed 18-resumed-running 19-reserve 20-kept 21-reserved \
  22-offline-exercise 23-safe 11-turning 11-turned 26-before-away 27-away 28-hand-in-away 29-back 30-no-server \
  33-results 34-panel 35-trouble 36-trouble-panel \
  38-reference-refused; do
  [ -s "$pictures/$n.png" ] || fail "no picture of $n"
done
echo "ok: a student and an instructor at the window, from sign-in to score and reference, after a crash and without the server"
