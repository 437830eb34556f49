#!/usr/bin/env bash
# The completions that packaging/manuals.mjs makes of the programs' help, asked as bash asks them: completion.sh BIN. What each
# program's own --help lists is offered after it; what somebody has begun to type narrows it.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
bin=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAILED: $*" >&2; exit 1; }
node "$root/packaging/manuals.mjs" "$bin" "$work" 0.1.0 2026-01-02
for program in server station lab; do
  # shellcheck disable=SC1090
  . "$work/enamel-$program.bash"
done

# offered PROGRAM WORD… LAST: a word in each line; LAST is what is being typed.
offered() {
  local complete
  complete=$(complete -p "$1" | sed 's/.*-F \([^ ]*\) .*/\1/')
  COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  "$complete"
  printf '%s\n' "${COMPREPLY[@]}"
}
offers() { # offers EXPECTED PROGRAM WORD… LAST
  local expected=$1 found
  shift
  found=$(offered "$@" | sort -u | tr '\n' ' ')
  [ "$found" = "$expected " ] || fail "after \"$*\": expected $expected, found $found"
}
offers "serve" enamel-server ser
offers "add-person" enamel-server admin add-p
offers "--login" enamel-server admin add-person --log
offers "--login" enamel-server admin add-person --role student --log
offers "--keyring" enamel-server restore /var/backups/enamel/2026-11-26 --key
offers "upload" enamel-station upl
offers "upload" enamel-station spool upl
offers "--again" enamel-station enrol --ag
offers "qualify" enamel-lab qual

# What may follow an option: its values, those that are built in, or, where it has neither, a file's name.
offers "admin instructor student" enamel-server admin add-person --role ""
offers "published" enamel-server admin list-exercises --data /var/lib/enamel --state p
offers "json text" enamel-station --log-format ""
offers "de en zh" enamel-station open --language ""
offers "omega3 omega6 omega7" enamel-station simulate --profile omega
offers "builtin:premolar" enamel-station simulate --scene builtin:pre
offers "class-5-molar-46-buccal" enamel-server admin assign-exercise --exercise class-5
offers "strokes" enamel-lab qualify --suite s
offers "molar-buccal molar-caries molar-caries-deep molar-caries-shallow molar-class-2 molar-left" enamel-lab pictures molar-
offers "" enamel-server admin add-person --login ""
offers "" enamel-station run --json ""

# All that a help lists, and nothing else.
lists() { # lists PROGRAM WORD…: commands and options of its help
  "$bin/$1" "${@:2}" --help | awk '
    /^Options:$|^Subcommands:$/ { on = 1; next } /^[A-Z]/ { on = 0 }
    on && /^  [^ ]/ {
      sub(/^  /, ""); sub(/  .*/, "")
      if (!/^-/) { print $1; next }
      sub(/[ {].*/, "")
      while (match($0, /--?[a-z][a-z0-9-]*/)) { print substr($0, RSTART, RLENGTH); $0 = substr($0, RSTART + RLENGTH) }
    }' | sort -u
}
checked=0
while read -r words; do
  # shellcheck disable=SC2086
  diff <(lists $words) <(offered $words "" | sort -u) >"$work/diff" || fail "completion of \"$words\" is not its help: $(cat "$work/diff")"
  checked=$((checked + 1))
done <<'COMMANDS'
enamel-server
enamel-server serve
enamel-server admin
enamel-server admin publish-exercise
enamel-server school
enamel-server restore
enamel-station
enamel-station run
enamel-station spool
enamel-station spool export
enamel-lab
enamel-lab qualify
COMMANDS

# Manual pages name every command of the program, and groff understands them.
for program in server station lab; do
  zcat "$work/enamel-$program.1.gz" >"$work/page"
  lists enamel-$program | grep -v '^-' | while read -r command; do
    grep -qx "\.SS ${command//-/\\\\-}" "$work/page" || fail "the manual page of enamel-$program lacks $command"
  done
  ! command -v groff >/dev/null || groff -Kutf8 -man -ww -z "$work/page" >"$work/log" 2>&1 && [ ! -s "$work/log" ] || fail "enamel-$program.1: $(head -3 "$work/log")"
done
echo "completions of $checked commands are their help"
