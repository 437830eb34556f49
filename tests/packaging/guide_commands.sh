#!/usr/bin/env bash
# Every command in a block of README.md and docs/: guide_commands.sh. It runs each as it is written, without root and without
# packages: folders of the system become folders of this test. ENAMEL_FULL=1 also runs those that take minutes, and those for a
# cluster, against PostgreSQL and Swift. Commands that change a machine run in another test; runner() names it.
. "$(dirname "$0")/../integration/support.sh"
. "$(dirname "$0")/guide_blocks.sh"
full=${ENAMEL_FULL:-} mode=${1:-}
port=$(free_ports)
data=$work/var/enamel
export ENAMEL_STATION_DATA=$work/station PATH=$bin:$PATH ENAMEL_PIN=271828
mkdir -m 700 "$work/var" "$work/backups" "$work/station" "$work/tmp" "$work/etc"

# Who runs a command of FILE: "here", "minutes", "cluster", a test, or "nobody: WHY". runner FILE COMMAND.
guide_blocks "$root/docs/for_it.md" '```sh' >"$work/debian"
runner() {
  case "$1: $2" in
    *": ./run"*) echo tests/integration/whole_job.sh ;;
    *": ./check"*) echo check ;;
    *ansible*) echo tests/packaging/chairs.sh ;;
    docs/api.md:*) command -v curl >/dev/null && command -v jq >/dev/null && echo here || echo "nobody: curl or jq is missing" ;;
    *"patronictl "*) echo tests/cluster/patroni.sh ;;
    *" calibrate --device hid"* | *" first-hour --device dhd"*) echo "nobody: it needs a unit" ;;
    docs/haptic_devices.md:*) echo "nobody: it needs a maker's driver" ;;
    docs/several_servers.md:* | *" psql school "*) echo cluster ;;
    *" simulate "* | *"enamel-lab operators"*) echo minutes ;;
    *" restore "*) echo tests/packaging/debian.sh ;;
    *": "*ENAMEL_P*" enamel-"* | *": enamel-"* | *"-- enamel-"* | *": printf "*) echo here ;;
    docs/for_it.md:*) grep -qxF -- "$2" "$work/debian" && echo tests/packaging/debian.sh ;;
  esac
}
# As it is written, with this test's folders and names.
here() {
  sed -E -e "s#https://enamel.example.edu/#http://127.0.0.1:$port/#" -e 's/runuser -u [a-z-]+ -- //' -e "s#/tmp/#$work/tmp/#g; s#/var/lib/#$work/var/#g" \
    -e "s#/var/backups/enamel#$work/backups#g; s#/etc/enamel#$work/etc#g" \
    -e "s#enamel.example.edu:8443#127.0.0.1:$((port + 1))#; s#^journalctl [^|]*#cat $work/server.log #" \
    -e "s#CODE@FINGERPRINT#\"\$(cat $work/code)\"#; s#( admin enrol-code --data \S+)\$#\1 | tee $work/code#" \
    -e "s#--codes -#& --name chair-01 --data $work/var/chair-01#" \
    -e 's#ENAMEL_(PASSWORD|PIN)=\.\.\. ##g; s#--user LOGIN#--user anna#; s#--exercise NAME#--exercise class-1-molar-46#' \
    -e 's#--profile NAME#--profile phantom_desktop#; s#--assignment ID#--assignment "$assignment"#' \
    -e 's#(--reserved|--give-back) ID#\1 "$reserved"#; s# run --reserved# run --lockstep --reserved#; s#result.bin --key KEY#"$result" --key "$key"#' \
    -e 's#^apt install \./.*\.deb#apt-get install -qq --simulate#; s#^apt install#apt-get install -qq --simulate#' \
    -e "s#-o enamel (-g enamel )?##; s#>>/etc/postgresql/15/main/#>>$work/etc/#; s#^ssh first##" \
    -e "s#tar -C / -c etc/enamel/server.toml var/lib/enamel/#tar -C $work -c etc/server.toml var/enamel/#; s#tar -C / -xp#tar -C \$second -xp#" \
    -e "s#postgresql://enamel(:PASSWORD)?@db/school[^ ']*#postgresql://enamel@/\${rows:-}?host=\${PGHOST:-}#; s#'postgresql:([^']*)'#\"postgresql:\1\"#" \
    -e "s#https://s3.example.org --s3-bucket school#\${ENAMEL_S3_ENDPOINT:-} --s3-bucket blobs --s3-prefix \$rows/#" \
    -e "s#--key-bucket school-keys#--key-bucket keys --key-prefix \$rows/#"
}
# What a person does before a command.
before() {
  case $1 in
    *" put-profile /tmp/mine.json"*)
      [ -f "$work/tmp/mine.json" ] || enamel-station calibrate --device simulated:bhhd3 --name mine --out "$work/tmp/mine.json" >/dev/null 2>&1 ;;
    *"--reserved ID" | *"--give-back ID")  # each takes one of its own
      reserved=$(enamel-station reserve --user anna --exercise class-1-molar-46 --profile phantom_desktop 2>/dev/null | grep -oE '[0-9a-f]{8}-[0-9a-f-]{27}' | tail -n 1) ;;
    *" agreement first.csv"*) for who in first second; do fill_in $who; done ;;
    *" move "*) folder_to_move ;;
  esac
}
# Everybody gives the full marks, and 3 for the work as a whole.
fill_in() {
  awk -F, -v OFS=, -v who="$1" 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i; print; next }
    { $at["marker"] = who; $at["mark"] = $at["full_marks"] == "" ? 3 : $at["full_marks"]; print }' "$work/tmp/to_mark.csv" >"$work/tmp/$1.csv"
}
# Two people's marks of one attempt give no pass mark, and the doctors warn of what this machine lacks: both exit with 1.
expected() {
  case "$1 $2" in
    "0 jq -"* | "0 jq '"*) ! grep -qw null "$work/out" ;;  # a member that an answer does not have
    "0 "*) ;;
    "1 "*" doctor "*) grep -qE '^(ok|warn|fail)  ' "$work/out" ;;
    "1 "*" standard "*) grep -q 'rated attempts' "$work/out" ;;
    *) false ;;
  esac
}
run() {
  local rc=0
  before "$2"
  eval "here_is() { $(here <<<"$2"); }"
  case $2 in
    systemctl*) here_is >"$work/out" 2>&1 </dev/null || rc=$? ;;
    *) (cd "$work/tmp" && here_is) >"$work/out" 2>&1 </dev/null || rc=$? ;;
  esac
  expected $rc "$2" || { cat "$work/out"; fail "$1: $2"; }
}
declare -A count=([here]=0 [later]=0 [there]=0 [nobody]=0 [named]=0)
try() {
  local file=$1 written who
  while IFS= read -r written; do
    who=$(runner "$file" "$written") || true
    case "$who $full $mode" in
      "here  " | "here 1 " | "minutes 1 " | "cluster 1 --cluster") run "$file" "$written"; who=here ;;
      here* | minutes* | cluster*) who=later ;;
      nobody:*) echo "$who: $written"; who=nobody ;;
      *) [ -n "$who" ] && [ -x "$root/${who%% *}" ] || fail "$file: nothing runs: $written"; who=there ;;
    esac
    count[$who]=$((count[$who] + 1))
  done < <(guide_blocks "$root/$file" '```' '```sh')
}

# Commands that sentences and units name: the program has them, and they have the options. `enamel-station` without a command is
# its window.
check_named() {
  local named program words options help option
  while IFS= read -r named; do
    read -r program words <<<"$named"
    options=$(grep -oE -- '--[a-z][a-z0-9-]*' <<<"$words" || true)
    read -r words <<<"$(sed -E 's/(^| )([^a-z].*)$//' <<<"$words")"
    help=$("$bin/$program" --help)
    [ -n "$words" ] || [ "$program" != enamel-station ] || words=open
    if [ -n "$words" ]; then
      help+=$("$bin/$program" $words --help)
      grep -qE "^Usage: .*enamel-[a-z]+ .*\b${words%% *}\b" <<<"$help" || fail "$program has no command ${words%% *}: $named"
    fi
    for option in $options; do
      grep -qE -- "(^|[ ,])$option([ ,=]|$)" <<<"$help" || fail "no $option: $named"
    done
    count[named]=$((count[named] + 1))
  done < <(
    cd "$root"
    sed -nE "s/^(\S+ )*['\`]?(ENAMEL_[A-Z]+=\S+ )*(enamel-(station|server|lab) [^'\`]*)['\`].*/\3/p" \
      < <(grep -ohE "['\`](ENAMEL_[A-Z]+=\S+ )*enamel-(station|server|lab) [^'\`]*['\`]" README.md docs/*.md {station,server}/{README.md,ops/*.service,ops/*.toml} station/lab/README.md)
    sed -nE 's#^ExecStart[A-Za-z]*=.*/usr/bin/(enamel-(station|server) .*)#\1#p' {station,server}/ops/*.service
  )
}

if [ "$mode" = --cluster ]; then
  # As PostgreSQL comes from Debian: a superuser postgres, and no enamel. Roles without a password are let in.
  export PGHOST=${ENAMEL_POSTGRES#host=}
  PGHOST=${PGHOST%% *}
  export PGDATABASE=postgres PGUSER=enamel rows=school
  createuser --superuser postgres
  export PGUSER=postgres
  psql -qc 'ALTER ROLE enamel RENAME TO first'
  printf '{"version": 1, "access_key": "%s", "secret_key": "%s"}\n' "$AWS_ACCESS_KEY_ID" "$AWS_SECRET_ACCESS_KEY" >"$work/tmp/s3.json"
  systemctl() {
    [ "$*" != "restart postgresql" ] || return 0
    # Of the second server, whose folder is another: beside the first.
    if [ -d "$second/var/enamel" ]; then
      [ -z "${beside:-}" ] || return 0
      local first=$server
      start_server "$second/var/enamel" "$(free_ports)"
      stop_server
      server=$first beside=yes
      [ "$(fingerprint "$second/var/enamel")" = "$(fingerprint "$data")" ] || fail "the second server is another one"
      return 0
    fi
    [ -z "${server:-}" ] || stop_server
    start_server "$data" "$port"
  }
  fingerprint() { sha256sum <"$1/station.crt"; }
  second=$work/second
  mkdir "$second"
  mkdir -m 700 "$data"
  touch "$work/etc/server.toml"
  folder_to_move() {
    stop_server
    rm -rf "$second/var"
    server=
    rm -rf "$data"
    enamel-server init --data "$data" >/dev/null
    rows=moved
    createdb --owner enamel moved
  }
  try docs/several_servers.md
  [ "${beside:-}" = yes ] || fail "the second server was not started"
  rows=moved
  try docs/for_it.md
  stop_server
  echo "${count[here]}" >"$ENAMEL_GUIDE_COUNT"
  exit
fi

check_named
[ "${count[named]}" -ge 40 ] || fail "found only ${count[named]} commands in sentences and units"
anna="what anna chose"
sed -e "s#/var/lib/enamel#$data#; s#/usr/share/enamel/web#$page_folder#; s#/var/backups/enamel#$work/backups#" \
  -e "s#^http = .*#http = \"127.0.0.1:$port\"#; s#^stations = .*#stations = \"127.0.0.1:$((port + 1))\"#" \
  "$root/server/ops/server.toml" >"$work/etc/server.toml"
printf 'login,display_name,role,cohort\nanna,Anna,student,Year 3\nbob,Bob,student,Year 3\nvera,Vera,instructor,Year 3\n' >"$work/tmp/year3.csv"
enamel-server init --data "$data" >/dev/null
enamel-server backup "$work/backups/20first" --data "$data" >/dev/null
start_server "$data" "$port"
try README.md
try docs/for_it.md
# attempt LOGIN OPERATOR [OPTION…]
attempt() {
  enamel-server admin set-password --login "$1" --password-stdin --data "$data" <<<"$anna" >/dev/null
  ENAMEL_PASSWORD=$anna enamel-station run --user "$1" --exercise class-1-molar-46 --profile phantom_desktop --operator "$2" \
    --lockstep --quiet --json "$work/$1.json" "${@:3}" >/dev/null 2>"$work/out" || { cat "$work/out"; fail "an attempt of $1"; }
  attempt=$(json_of "$work/$1.json" attempt_id)
}
attempt vera dentist --as-reference
enamel-server report --data "$data" --attempt "$attempt" --wait 120 >/dev/null 2>&1 || true
enamel-server admin mark-reference --attempt "$attempt" --dentist "Simulated dentist" --consent --data "$data" >/dev/null
attempt anna student
enamel-server report --data "$data" --attempt "$attempt" --wait 120 >/dev/null || fail "the attempt is not scored"
enamel-server admin export-person "$work/mine" --login anna --data "$data" >/dev/null
result=$work/mine/attempts/$attempt/result.bin
key=$(enamel-server admin list-stations --data "$data" | sed -nE "s/^key of this server's tickets and results +//p")
assignment=$(enamel-server admin list-assignments --data "$data" | grep -v practice | cut -d ' ' -f 1)
export ENAMEL_PASSWORD=$anna
for guide in api for_instructors at_the_chair for_data_protection for_researchers first_exam first_week haptic_devices is_it_for_you pilot what_a_hand_feels paper README; do
  try "docs/$guide.md"
done
mode=counts try docs/several_servers.md
stop_server
if [ "$full" = 1 ]; then
  export ENAMEL_GUIDE_COUNT=$work/count
  "$root/tests/support/with_postgres.sh" "$root/tests/cluster/with_swift.sh" "$0" --cluster && count[cluster]=$(cat "$work/count") ||
    { [ $? = 77 ] || fail "the commands for a cluster"; }
  count[here]=$((count[here] + ${count[cluster]:-0}))
  count[later]=$((count[later] - ${count[cluster]:-0}))
fi
all=$((count[here] + count[later] + count[there] + count[nobody]))
echo "$all commands in README.md and docs/: ${count[here]} ran here, ${count[there]} run in other tests, ${count[later]} run with ENAMEL_FULL=1, ${count[nobody]} in none"
[ $all -ge 75 ] || fail "found only $all commands"
