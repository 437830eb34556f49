#!/usr/bin/env bash
# What a school shows of itself to whoever helps: doctor finds nothing wrong with a running server and names what is broken
# then; a support bundle of it has its settings, figures and log, and no name, address, password, key or token. On a full
# disk the reason is said and nothing is left.
. "$(dirname "$0")/support.sh"
command -v curl >/dev/null || { echo "skipped: curl is not installed"; exit 77; }
data=$work/server
port=$(free_ports)
"$bin/enamel-server" init --data "$data" >/dev/null
token=$(head -c 24 /dev/urandom | base64 | tr -d '=+/')
echo "$token" >"$work/token"
settings=(--data "$data" --http "127.0.0.1:$port" --stations "127.0.0.1:$((port + 1))" --metrics-token-file "$work/token"
  --host-name praxis.quellbach.example --host-name 127.0.0.1)
password="a quite unlikely password 7"
# person LOGIN NAME ROLE
person() { "$bin/enamel-server" admin add-person --data "$data" --login "$1" --name "$2" --role "$3" --password-stdin >/dev/null <<<"$password"; }
person wilhelmine "Wilhelmine Zückermandl" admin
person jorgeluis "Jorge Luis Quintanilla" student
"$bin/enamel-server" admin add-cohort --data "$data" --name "Jahrgang Abendroth" >/dev/null
start_server "$data" "$port" --log-format json --log-level debug "${settings[@]:6}"
"$bin/enamel-station" enrol --data "$work/station" --server "127.0.0.1:$((port + 1))" \
  --code "$("$bin/enamel-server" admin enrol-code --data "$data")" --name "Stuhl Nepomuk" >/dev/null
# The log gets a refusal from an address of its own, a sign-in and its cookie's requests.
sign_in() { curl -s -o /dev/null -w '%{http_code}' --interface "$1" -c "$work/cookies" -H 'Content-Type: application/json' -d "{\"login\": \"$2\", \"password\": \"$3\"}" "http://127.0.0.1:$port/api/v1/session"; }
[ "$(sign_in 127.0.0.77 jorgeluis "guess of somebody")" = 401 ] || fail "a wrong password was not refused"
[ "$(sign_in 127.0.0.78 wilhelmine "$password")" = 200 ] || fail "nobody can sign in"
cookie=$(awk '/enamel_session/ { print $NF }' "$work/cookies")
curl -s -o /dev/null -b "enamel_session=$cookie" "http://127.0.0.1:$port/api/v1/people"
# The computer's own name, where this test may give it one.
own=() named=()
if unshare -u true 2>/dev/null; then
  own=(unshare -u sh -c 'hostname rechner-zwetschge; exec "$@"' _) named=(zwetschge)
fi
# A line that no program of ours writes; the server's own file is written on by it.
cp "$work/server.log" "$work/log"
echo "something else says: Wilhelmine Zückermandl <w.z@example.org> from 198.51.100.23 to Rechner-Zwetschge and db.quellbach.example, key $token, attempt 01a213df-e6ae-700b-b588-6f4b2fe580f4" >>"$work/log"

"$bin/enamel-server" doctor "${settings[@]}" --json "$work/doctor.json" >"$work/doctor" || { cat "$work/doctor"; fail "doctor finds a fault in a server that is well"; }
grep -q '^ok    server            it says ok' "$work/doctor" || { cat "$work/doctor"; fail "doctor does not see that the server runs"; }
"${own[@]}" "$bin/enamel-server" support-bundle "$work/bundle.json" "${settings[@]}" --log "$work/log"
[ "$(stat -c %a "$work/bundle.json")" = 600 ] || fail "others may read the bundle"
node -e '
  const bundle = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8"));
  const said = (ok, what) => { if (!ok) { console.error(`FAILED: the bundle has no ${what}`); process.exit(1); } };
  said(bundle.format === 1 && bundle.version.startsWith("enamel-server "), "version");
  said(bundle.settings.some((line) => line.startsWith("metrics-token-file")), "settings");
  said(bundle.doctor.some((f) => f.what === "data folder" && f.verdict === "ok"), "finding of the folder");
  said(JSON.parse(bundle.readyz).status === "ok", "answer of /readyz");
  said(bundle.log.some((line) => line.level && line.time && line.message), "line of the log");
  said(bundle.log.some((line) => typeof line === "string" && line.includes("something else says")), "line of text");
' "$work/bundle.json"
! grep -oE '[:,[]-?[0-9.]+E-?[0-9]+' "$work/bundle.json" || fail "the bundle has numbers that people do not read"
secrets=("$password" "guess of somebody" "$token" "$cookie" "$(tail -c 32 "$data/ticket.key" | base64 | cut -c1-30)" "$(sed -n 2p "$data/station.key")")
for text in "${named[@]}" quellbach wilhelmine jorgeluis Zückermandl Quintanilla Abendroth Nepomuk 127.0.0.77 127.0.0.78 198.51.100.23 w.z@example.org \
  01a213df-e6ae-700b-b588-6f4b2fe580f4 "${secrets[@]}"; do
  ! grep -qiF -- "$text" "$work/bundle.json" || { grep -oiE ".{60}$text.{20}" "$work/bundle.json" | head -3; fail "the bundle has \"$text\""; }
done
for key in $(find "$data" -name '*.key' -size -1k); do
  ! grep -qF -- "$(head -c 400 "$key" | tr -d '\n' | cut -c1-30)" "$work/bundle.json" || fail "the bundle has $(basename "$key")"
done
echo "ok: a bundle of $(stat -c %s "$work/bundle.json") bytes without names and secrets"

# Without the database nobody knows whose names to take out.
stop_server
mv "$data/enamel.db" "$work/away.db"
"$bin/enamel-server" support-bundle - "${settings[@]}" --log "$work/log" >"$work/without.json"
[ "$(node -p 'const b = JSON.parse(require("fs").readFileSync(process.argv[1], "utf8")); b.log === null && b.log_problem.includes("left out")' "$work/without.json")" = true ] || fail "a log is in a bundle without the database"
mv "$work/away.db" "$data/enamel.db"
expect_failure "the folder lets others in" "see 'fail' above" bash -c "chmod 755 '$data'; trap 'chmod 700 $data' EXIT; '$bin/enamel-server' doctor ${settings[*]}"
# A file system of its own, full.
if unshare -m true 2>/dev/null; then
  mkdir "$work/full"
  expect_failure "a bundle on a full disk" "No space left|full" unshare -m bash -c "mount -t tmpfs -o size=64k none '$work/full' && { dd if=/dev/zero of='$work/full/filler' bs=4k 2>/dev/null; '$bin/enamel-server' support-bundle '$work/full/bundle.json' ${settings[*]}; rc=\$?; [ ! -e '$work/full/bundle.json' ] || echo 'something is left'; exit \$rc; }"
  ! grep -q 'something is left' "$work/out" || fail "part of a bundle is left"
fi
echo "ok: what is broken is named, and nothing is left on a full disk"
