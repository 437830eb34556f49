#!/usr/bin/env bash
# A server behind the HAProxy that server/ops/haproxy.cfg describes, and behind the nginx of server/ops/nginx.conf: the page
# is reached over HTTPS and a station makes an attempt over HAProxy's link, whose TLS ends at the server; the log names who
# asked and not the proxy; what a proxy packs can be edited, and live events come as they are made; a server that is asked
# to stop is given no more before it does. Skips where HAProxy, nginx, curl or openssl is not installed.
. "$(dirname "$0")/../integration/support.sh"
for program in haproxy nginx curl openssl; do
  command -v $program >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
data=$work/server station=$work/station
port=$(free_ports)
page=$(free_ports)
shown=$page packing=$(free_ports) nginx=$(free_ports)
export ENAMEL_PASSWORD="a quite unlikely password 7"
server_cli() { "$bin/enamel-server" "$@"; }

openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=enamel.test -addext subjectAltName=DNS:enamel.test \
  -keyout "$work/page.key" -out "$work/page.crt" 2>/dev/null
cat "$work/page.crt" "$work/page.key" >"$work/page.pem"

server_cli init --data "$data" >/dev/null
server_cli seed-demo --data "$data" --voxel-um 100 --json "$work/seed" >/dev/null
exercise=$(json_of "$work/seed" exercise)
# The demo's passwords are printed in our documents: behind a proxy the server does not start with them.
behind=(--http-behind-proxy 127.0.0.1 --stations-behind-proxy 127.0.0.1 --host-name enamel.test --drain-seconds 600)
expect_failure "public passwords behind a proxy" "passwords of their own" "$bin/enamel-server" serve --data "$data" \
  --http "127.0.0.1:$port" --stations "127.0.0.1:$((port + 1))" --stations-behind-proxy 127.0.0.1
for login in admin instructor student1 student2; do
  printf '%s\n' "$ENAMEL_PASSWORD" | server_cli admin set-password --data "$data" --login "$login" --password-stdin >/dev/null
done
expect_failure "a proxy's name" "numeric address" "$bin/enamel-server" serve --data "$data" --http "127.0.0.1:$port" \
  --stations "127.0.0.1:$((port + 1))" --stations-behind-proxy proxy.example.edu
start_server "$data" "$port" "${behind[@]}"
# Asked twice to end it would still drain.
trap 'kill -KILL "$server" 2>/dev/null || true; stop_all' EXIT

export ENAMEL_PAGE_ADDRESS=127.0.0.1:$page ENAMEL_STATIONS_ADDRESS=127.0.0.1:$((page + 1)) ENAMEL_PAGE_CERTIFICATE=$work/page.pem
export ENAMEL_HOST_NAME=enamel.test ENAMEL_SERVER_ONE=127.0.0.1 ENAMEL_SERVER_TWO=127.0.0.2
export ENAMEL_SERVER_PAGE_PORT=$port ENAMEL_SERVER_STATION_PORT=$((port + 1))
haproxy -f "$root/server/ops/haproxy.cfg" >"$work/haproxy.log" 2>&1 &
pids+=($!)

# ask PATH [options]: the page as a browser asks for it; prints the status.
ask() {
  local path=$1
  shift
  curl -s -o "$work/answer" -w '%{http_code}' --cacert "$work/page.crt" --resolve "enamel.test:$page:127.0.0.1" "$@" "https://enamel.test:$page$path"
}
# Said after its first look at both servers, so it listens.
wait_for_log "$work/haproxy.log" 'page_servers/two is DOWN'
[ "$(ask /readyz)" = 200 ] || fail "the server is not asked: $(cat "$work/answer")"
grep -q '"ok"' "$work/answer" || fail "the server is not well: $(cat "$work/answer")"
[ "$(ask /)" = 200 ] || fail "the page was not served"

# Who claims an address of somebody else's is not believed: the proxy says where the request came from.
# Nor who names a request.
ask /api/v1/session --interface 127.0.0.3 -D "$work/head" -H 'X-Forwarded-For: 192.0.2.99' -H 'X-Request-Id: mine' -H 'Content-Type: application/json' -H "Origin: https://enamel.test:$page" \
  -d '{"login": "student1", "password": "wrong"}' >"$work/status"
[ "$(cat "$work/status")" = 401 ] || fail "a wrong password was answered $(cat "$work/status"): $(cat "$work/answer")"
grep -q '127\.0\.0\.3' "$work/server.log" || { cat "$work/server.log"; fail "the log does not name who asked"; }
! grep -q '192\.0\.2\.99' "$work/server.log" || fail "a claimed address was believed"
request=$(sed -n 's/^x-request-id: \([0-9a-f-]\{36\}\)\r$/\1/ip' "$work/head")
[ -n "$request" ] || { cat "$work/head"; fail "the answer does not name its request as the proxy does"; }
grep -q "\[request $request\] .* refused" "$work/server.log" || { cat "$work/server.log"; fail "the log does not say what became of request $request"; }
echo "ok: the page over HTTPS, asked by 127.0.0.3 in request $request"

# Over the link: bytes that are no frame, from an address of its own.
# It goes on reading after its own end (-quiet), until the server ends the connection.
printf 'GET / HTTP/1.1\r\n\r\n' | timeout 20 openssl s_client -bind 127.0.0.4:0 -connect "127.0.0.1:$((page + 1))" -quiet >/dev/null 2>&1 || true
wait_for_log "$work/server.log" '127\.0\.0\.4'

"$bin/enamel-station" enrol --data "$station" --server "127.0.0.1:$((page + 1))" --code "$(server_cli admin enrol-code --data "$data")" --name behind
"$bin/enamel-station" run --data "$station" --profile phantom_desktop --lockstep --quiet --exercise "$exercise" --user instructor \
  --operator dentist --as-reference --json "$work/cut.json" >/dev/null
server_cli report --data "$data" --attempt "$(json_of "$work/cut.json" attempt_id)" --wait 600 --json "$work/report.json" >/dev/null
[ "$(json_of "$work/report.json" ticks)" = "$(json_of "$work/cut.json" ticks)" ] || fail "not every tick came through the proxy"
echo "ok: an attempt of $(json_of "$work/cut.json" ticks) ticks over the link"

# Both proxies again, as somebody sets them up who has them pack all they may.
export ENAMEL_PAGE_ADDRESS=127.0.0.1:$packing ENAMEL_STATIONS_ADDRESS=127.0.0.1:$((packing + 1))
sed '/^backend page_servers/a\  compression algo gzip\n  compression type application/json text/event-stream' \
  "$root/server/ops/haproxy.cfg" >"$work/packing.cfg"
haproxy -f "$work/packing.cfg" >"$work/packing.log" 2>&1 &
pids+=($!)
wait_for_log "$work/packing.log" 'page_servers/two is DOWN'

# start_nginx PORT FOLDER SED: the site with this machine's names, changed by SED; in the foreground, its files in FOLDER.
start_nginx() {
  local port_here=$1 folder=$2
  mkdir -p "$folder"
  sed -e "s|listen 443|listen 127.0.0.1:$port_here|; /listen \[::\]/d; s|enamel.example.edu|enamel.test|; s|127.0.0.1:8080|127.0.0.1:$port|" \
    -e "s|/etc/nginx/enamel|$work/page|; $3" "$root/server/ops/nginx.conf" >"$folder/site.conf"
  cat >"$folder/nginx.conf" <<EOF
worker_processes 1; pid $folder/nginx.pid; error_log $folder/error.log notice; daemon off; master_process off;
events {}
http {
  access_log off;
  client_body_temp_path $folder/a; proxy_temp_path $folder/b; fastcgi_temp_path $folder/c; uwsgi_temp_path $folder/d; scgi_temp_path $folder/e;
  gzip_types application/json; gzip_proxied any;
  include $folder/site.conf;
}
EOF
  nginx -p "$folder" -c "$folder/nginx.conf" -e "$folder/error.log" >"$folder/log" 2>&1 &
  pids+=($!)
  wait_for_log "$folder/error.log" 'event method'
}
start_nginx "$nginx" "$work/nginx" ""
start_nginx "$((nginx + 1))" "$work/nginx-packing" "s|gzip off|gzip on|"
page=$nginx
[ "$(ask /readyz)" = 200 ] || fail "the server is not asked by nginx: $(cat "$work/answer")"
ask /api/v1/session --interface 127.0.0.5 -D "$work/head" -H 'X-Forwarded-For: 192.0.2.99' -H 'Content-Type: application/json' \
  -H "Origin: https://enamel.test:$page" -d '{"login": "student1", "password": "wrong"}' >"$work/status"
[ "$(cat "$work/status")" = 401 ] || fail "a wrong password was answered $(cat "$work/status"): $(cat "$work/answer")"
grep -q '127\.0\.0\.5' "$work/server.log" || { cat "$work/server.log"; fail "the log does not name who asked nginx"; }
! grep -q '192\.0\.2\.99' "$work/server.log" || fail "a claimed address was believed behind nginx"

"$bin/enamel-station" run --data "$station" --profile phantom_desktop --quiet --exercise "$exercise" --user student1 --operator student >"$work/run.log" 2>&1 &
run=$!
pids+=("$run")
node "$root/tests/cluster/through_proxies.mjs" "$port" "$work/page.crt" "HAProxy=$packing" "nginx=$((nginx + 1))" || { cat "$work/run.log"; fail "not through a proxy"; }
kill -KILL "$run"
wait "$run" 2>/dev/null || true
page=$shown

kill -TERM "$server"
wait_for_log "$work/haproxy.log" 'page_servers/one is stopping'
[ "$(ask /readyz)" = 503 ] || fail "the proxy has somebody to ask: $(cat "$work/answer")"
kill -0 "$server" || fail "the server has stopped before its time to drain was over"
# Who asks the server itself is still answered.
[ "$(curl -s -o "$work/answer" -w '%{http_code}' -H 'Host: enamel.test' "http://127.0.0.1:$port/readyz")" = 404 ] || fail "it is not draining"
grep -q '"draining"' "$work/answer" || fail "it does not say why: $(cat "$work/answer")"
echo "ok: taken out of the round before it stops"
# Its time to drain is longer than anybody waits here.
kill_server
