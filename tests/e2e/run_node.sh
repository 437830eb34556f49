#!/bin/sh
# Runs a node script of the page's tests, or ends with 77 (skipped) and says what is missing.
#   run_node.sh WEB_DIR NODE_ARGUMENTS...
web=$1
shift
if ! command -v node >/dev/null 2>&1; then
  echo "skipped: node is not installed (Debian package nodejs)"
  exit 77
fi
if [ ! -d "$web/node_modules/esbuild" ]; then
  echo "skipped: the page's packages are not installed: run 'npm ci' in $web"
  exit 77
fi
exec node "$@"
