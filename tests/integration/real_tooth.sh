#!/usr/bin/env bash
# The demo's exercise on a real crown: real_tooth.sh SHARED_DATA
. "$(dirname "$0")/support.sh"
crown=$1/crowns/fdi_46.obj
[ -r "$crown" ] || { echo "skipped: no shared data"; exit 77; }
cd "$root"
port=$(free_ports)
./run --once --tooth "$crown" --data "$work/data" --port "$port" --json "$work/1.json"
node tests/integration/check_facts.mjs "$work/1.json"
