#!/usr/bin/env bash
# An exam that a second person signs at the chair: without a signature it does not begin and its ticket counts for nothing;
# signed at start and end, also after it was cut off and resumed. At the window: a wrong PIN, then the right one; an end that
# is signed, and one that nobody signs and that is stored all the same. ENAMEL_PICTURES=FOLDER keeps the pictures.
. "$(dirname "$0")/support.sh"
pictures=${ENAMEL_PICTURES:-$work/pictures}
mkdir -p "$pictures"
station="$work/station" data="$work/server"
export LC_ALL=C.UTF-8  # it reads English

"$bin/enamel-server" init --data "$data" >/dev/null
"$bin/enamel-server" seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
port=$(free_ports)
start_server "$data" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name "Chair 7" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" >/dev/null
ENAMEL_PASSWORD=enamel-demo-instructor "$bin/enamel-station" run --data "$station" --exercise "$exercise" --quiet \
  --profile phantom_desktop --user instructor --operator dentist --lockstep --as-reference --json "$work/reference" >/dev/null
reference=$(json_of "$work/reference" attempt_id)
"$bin/enamel-server" report --data "$data" --attempt "$reference" --wait $((120 * patience)) >/dev/null
"$bin/enamel-server" admin mark-reference --data "$data" --attempt "$reference" --dentist "Simulated dentist" --consent >/dev/null
"$bin/enamel-server" admin assign-exercise --data "$data" --exercise "$exercise" --cohort "Demo cohort" --attempts 1 \
  --exam --sign-off --outline always --hands any >"$work/exam.txt"
grep -q "exam signed at the chair" "$work/exam.txt" || fail "it was not assigned with a sign-off"
by_page() { node "$root/tests/integration/sign_off.mjs" "$port" instructor enamel-demo-instructor "$@"; }
by_page pin 804217

echo "== without a window"
export ENAMEL_PASSWORD=enamel-demo-student1
exam=("$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise"
  --assignment "$(cut -d ' ' -f 1 "$work/exam.txt")" --operator student)
expect_failure "nobody signs" "needs the signature of an instructor at the chair" "${exam[@]}" --user student1
expect_failure "a wrong PIN" "login or PIN is wrong" env ENAMEL_SIGNER_PIN=804218 "${exam[@]}" --user student1 --signer instructor
expect_failure "the student's own" "login or PIN is wrong" env ENAMEL_SIGNER_PIN=804217 "${exam[@]}" --user student1 --signer student1
# One attempt is allowed: the tickets above were given back.
ENAMEL_SIGNER_PIN=804217 "${exam[@]}" --user student1 --signer instructor --json "$work/signed.json"
[ "$(by_page signatures "$(json_of "$work/signed.json" attempt_id)")" = "Demo instructor, Demo instructor" ] ||
  fail "signed by $(by_page signatures "$(json_of "$work/signed.json" attempt_id)")"
expect_failure "a second attempt" "1 is used" env ENAMEL_SIGNER_PIN=804217 "${exam[@]}" --user student1 --signer instructor
echo "ok: begins only when it is signed, and is signed at its end"

echo "== cut off"
add_students "$data" 2
cut_off "$station" 20 env ENAMEL_SIGNER_PIN=804217 "${exam[@]}" --user chair2 --signer instructor
ENAMEL_SIGNER_PIN=804217 "$bin/enamel-station" run --data "$station" --lockstep --quiet --user chair2 --operator student \
  --resume last --signer instructor
[ "$(by_page signatures "$attempt")" = "Demo instructor, Demo instructor" ] || fail "signed by $(by_page signatures "$attempt")"
echo "ok: signed at its end after it was resumed"

echo "== at the window"
start_display
# exam_of LOGIN PASSWORD: plays the script on standard input; `attempt` is the one that was made.
exam_of() {
  cat - <(echo quit) | sed "s|LOGIN|$1|; s|PASSWORD|$2|; s|PICTURES|$pictures|" >"$work/$1.txt"
  timeout $((600 * patience)) "$bin/enamel-station" open --data "$station" --window 1280x720 --no-sound --simulated \
    --script "$work/$1.txt" || { tail -n 20 "$work/server.log"; fail "the script of $1 did not get through"; }
  attempt=$(newest "$station")
}
begins='page sign-in
type LOGIN
key Tab
type PASSWORD
key Enter
page exercises
key Enter
page exercise
see An instructor signs at this chair
see Bur:
click Start
page sign-off
see An instructor signs the start
frames 3
picture PICTURES/sign-off-start.png
type instructor
key Enter
type 804218
key Enter
see Wrong login or PIN
frames 3
picture PICTURES/sign-off-wrong.png
type 804217
key Enter
page running
frames 120
picture PICTURES/outline.png
key T
frames 3
picture PICTURES/no-outline.png
key F
page finish
click Hand in
page sign-off
see Your recording is safe
frames 3
picture PICTURES/sign-off-end.png'
exam_of student2 enamel-demo-student2 <<EOF
$begins
type instructor
key Enter
type 804217
key Enter
page result
see Handed in
# There is no attempt left to try again with: the focus is at the exercises.
frames 2
key Enter
page exercises
see the only attempt is used
EOF
[ "$(by_page signatures "$attempt")" = "Demo instructor, Demo instructor" ] || fail "signed by $(by_page signatures "$attempt")"
# The assignment lets the student see the outline, which T hides.
blue() { node "$root/tests/integration/blue.mjs" "$pictures/$1.png"; }
[ "$(blue outline)" -gt 300 ] || fail "the exam shows no outline: $(blue outline) blue pixels"
[ "$(blue no-outline)" -lt 30 ] || fail "T hides no outline: $(blue no-outline) blue pixels"

exam_of chair1 "$ENAMEL_PASSWORD" <<EOF
$begins
# Esc, pressed by habit, hands nothing in.
key Escape
frames 3
see Your recording is safe
click Hand in unsigned
page result
see Handed in
EOF
[ "$(by_page signatures "$attempt")" = "Demo instructor, -" ] || fail "signed by $(by_page signatures "$attempt")"
stop_server
echo "ok: signed at the end, and not signed and stored all the same"
