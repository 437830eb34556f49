#!/usr/bin/env bash
# The station's window in German and Chinese: from sign-in through an attempt to its pages, and the language chosen on the
# first page. ENAMEL_PICTURES=FOLDER keeps the pictures.
. "$(dirname "$0")/support.sh"
start_display
pictures=${ENAMEL_PICTURES:-$work/pictures}
mkdir -p "$pictures"
station="$work/station"

"$bin/enamel-server" init --data "$work/server" >/dev/null
"$bin/enamel-server" seed-demo --data "$work/server" --voxel-um 100 --json "$work/seed" >/dev/null
port=$(free_ports)
start_server "$work/server" "$port"
"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((port + 1))" --name "Chair 7" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$work/server")" >/dev/null

# play NAME [options]: a script on standard input.
play() {
  sed "s|PICTURES|$pictures|" >"$work/$1.txt"
  timeout 300 "$bin/enamel-station" open --data "$station" --window 1280x720 --no-sound --script "$work/$1.txt" "${@:2}" ||
    { tail -n 20 "$work/server.log"; fail "the script $1 did not get through"; }
}

play german --language de <<'EOF'
page sign-in
see Anmeldename
picture PICTURES/de-1-sign-in.png
type student1
key Tab
type enamel-demo-student1
key Enter
page exercises
see Guten Tag,
frames 2
picture PICTURES/de-2-exercises.png
key Enter
page exercise
see Bohrer:
frames 3
picture PICTURES/de-3-exercise.png
click Start
page running
frames 30
picture PICTURES/de-4-running.png
key Escape
page paused
see Der Bohrer ist aus
frames 2
picture PICTURES/de-5-paused.png
click Versuch aufgeben
page give-up
click Versuch aufgeben
page result
frames 5
picture PICTURES/de-6-result.png
quit
EOF

# Chosen on the first page, by who cannot read the language that it has.
if [ -e /usr/share/fonts/opentype/noto/NotoSansCJK-Regular.ttc ]; then
  LANG=C.UTF-8 play chinese <<'EOF'
page sign-in
see Login
click 中文
see 用户名
frames 2
picture PICTURES/zh-1-sign-in.png
click 用户名
type student1
key Tab
type enamel-demo-student1
key Enter
page exercises
see 您好
frames 2
picture PICTURES/zh-2-exercises.png
key Enter
page exercise
see 车针
frames 3
picture PICTURES/zh-3-exercise.png
quit
EOF
else
  # Without letters for it Chinese is no choice.
  play letters <<'EOF'
page sign-in
see Deutsch
quit
EOF
fi
# A computer that speaks German begins in German.
unset LC_ALL
export LC_MESSAGES=de_AT.UTF-8
play locale <<'EOF'
page sign-in
see Anmeldename
quit
EOF
status=0
"$bin/enamel-station" open --data "$station" --language tlh 2>"$work/refused" || status=$?
[ "$status" -eq 2 ] || fail "an unknown language was taken"
grep -q 'de' "$work/refused" || fail "the refusal does not say which languages there are"
echo "the window speaks German and Chinese"
