#!/usr/bin/env bash
# An exam as examiners hold it (docs/for_instructors.md), on the real programs: three references, a rubric with a material and
# critical errors, twenty attempts, blind marks by two, agreement, a pass mark, release, an appeal, and a signed result that
# the Python script checks alone. The page is tried in Chromium where there is one. With ENAMEL_FULL=1.
#   examiner.sh [DIST]    DIST: the built page
. "$(dirname "$0")/support.sh"
skip() { echo "skipped: $*"; exit 77; }
[ "${ENAMEL_FULL:-}" = 1 ] || skip "ENAMEL_FULL=1 runs it"
[ $patience = 1 ] || skip "minutes of release programs are an hour of a sanitizer's"
python3 -c 'import cryptography' 2>/dev/null || skip "python3-cryptography is not installed"
export ENAMEL_PASSWORD="a long enough phrase"
data=$work/server
server_cli() { "$bin/enamel-server" "$@" --data "$data"; }
person() {  # LOGIN ROLE NAME
  printf '%s\n' "$ENAMEL_PASSWORD" | server_cli admin add-person --login "$1" --role "$2" --name "$3" --password-stdin >/dev/null
  server_cli admin add-to-cohort --cohort "Year 2" --login "$1" >/dev/null
}

# Voxels of 0.1 mm, which 27 scores against three references take a minute for.
molar=${ENAMEL_SHARED_DATA:-$root/../shared/data}/crowns/fdi_46.obj
scene=(--scene builtin:molar --voxel-um 100)
server_cli init >/dev/null
if [ -f "$molar" ]; then
  "$bin/enamel-station" import "$molar" --tooth 46 --unit mm --voxel-um 100 --out "$work/molar" >/dev/null 2>&1
  scene=(--scene "$work/molar")
fi
server_cli admin publish-exercise "${scene[@]}" --name class-1 --unassigned >"$work/published"
server_cli admin add-cohort --name "Year 2" >/dev/null
printf '%s\n' "$ENAMEL_PASSWORD" | server_cli admin add-person --login root --role admin --password-stdin >/dev/null
person vega instructor "Dr Vega"
person dean instructor "Dr Dean"
person okafor instructor "Dr Okafor"
for i in $(seq 10); do person "s$i" student "Candidate Number$i"; done

port=$(free_ports)
[ ! -f "${1:-}/index.html" ] || page_folder=$1
start_server "$data" "$port"
"$bin/enamel-station" enrol --data "$work/station" --server "127.0.0.1:$((port + 1))" --name "Chair 1" \
  --code "$(server_cli admin enrol-code)" >/dev/null
key=$(server_cli admin list-stations | sed -n "s/^key of this server.s tickets and results *//p")
timeout 1500 node "$root/tests/integration/examiner.mjs" "$bin" "$work" "$port" \
  "$(sed -nE 's/^exercise "([^"]+)".*/\1/p' "$work/published" | head -n 1)" "$key"
server_cli verify >"$work/verify.log" || { cat "$work/verify.log"; fail "what is stored does not agree"; }
stop_server
echo "an exam from its references to its appeal: passed"
