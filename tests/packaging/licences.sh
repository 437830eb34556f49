#!/usr/bin/env bash
# Every file says, by REUSE 3.0, whose it is and under which licence: .reuse/dep5. Sources that name another licence or other
# people in themselves are named there, too.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -e .git ] || { echo "skipped: not a git checkout, so built files cannot be told from sources"; exit 77; }
others=$(git grep -lE '^(#|//|/?\*| \*)? ?(Copyright \(c\)|SPDX-License-Identifier)' -- ':!LICENSE' ':!LICENSES' ':!packaging/copyright' ':!tests/packaging' || true)
for file in $others; do
  grep -qxF "Files: $file" .reuse/dep5 || { echo "FAILED: $file names a copyright, and .reuse/dep5 does not name it" >&2; exit 1; }
done
command -v reuse >/dev/null || { echo "skipped: reuse is not installed"; exit 77; }
reuse lint || exit 1
