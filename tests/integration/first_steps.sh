#!/usr/bin/env bash
# A new server by its page alone: the link that it prints makes the first admin, once; that admin puts a tooth with its
# exercises, and finds them published; a server that has an admin prints no link.
. "$(dirname "$0")/support.sh"
port=$(free_ports)
data=$work/data
server=""
post() {  # PATH BODY: prints STATUS BODY, and keeps cookie and csrf
  node -e '
    const { existsSync, readFileSync, writeFileSync } = require("fs");
    const [base, file, path, body] = process.argv.slice(1);
    const pass = existsSync(file) ? JSON.parse(readFileSync(file)) : {};
    const headers = { "Content-Type": "application/json", ...pass };
    fetch(base + path, { method: body === "" ? "GET" : "POST", headers, body: body === "" ? undefined : body }).then(async (answer) => {
      const text = await answer.text();
      const cookie = answer.headers.get("set-cookie");
      if (cookie && answer.ok) writeFileSync(file, JSON.stringify({ Cookie: cookie.split(";")[0], "X-Enamel-Csrf": JSON.parse(text).csrf }));
      console.log(answer.status + " " + text);
    });' "http://127.0.0.1:$port" "$work/head.json" "$1" "${2-}"
}
expect() {  # STATUS PATH BODY
  local answer
  answer=$(post "$2" "${3-}")
  [ "${answer%% *}" = "$1" ] || fail "$2: expected $1, found $answer"
  echo "${answer#* }"
}

start_server "$data" "$port"
# The link comes right after "ready".
for _ in $(seq 100); do
  grep -q '^first admin' "$work/server.log" && break
  sleep 0.1
done
token=$(sed -n 's|^first admin: open http://127.0.0.1:[0-9]*/first#\([0-9a-f]*\) .*|\1|p' "$work/server.log")
[ ${#token} = 64 ] || fail "expected a link for the first admin, found $(cat "$work/server.log")"
account() { printf '{"token":"%s","login":"head","display_name":"Head","password":"quite a long phrase of mine"}' "$1"; }
expect 403 /api/v1/first-admin "$(account "${token//[0-9]/f}")" >/dev/null
expect 201 /api/v1/first-admin "$(account "$token")" >/dev/null
expect 403 /api/v1/first-admin "$(account "$token")" >/dev/null
expect 200 /api/v1/session '{"login":"head","password":"quite a long phrase of mine"}' >/dev/null
expect 201 /api/v1/builtin-teeth '{"name":"block"}' >"$work/first.json"
expect 201 /api/v1/builtin-teeth '{"name":"block"}' >"$work/again.json"
cmp "$work/first.json" "$work/again.json" || fail "expected the same exercises when it is asked again"
expect 200 '/api/v1/exercises?state=published' | grep -q '"state":"published"' || fail "expected published exercises"
expect 400 /api/v1/builtin-teeth '{"name":"tusk"}' >/dev/null
grep -rqs "$token" "$data" && fail "expected the token nowhere in the data folder"
stop_server
start_server "$data" "$port"
stop_server
grep -q '^first admin' "$work/server.log" && fail "expected no link from a server that has an admin"
echo "a new server's first steps: passed"
