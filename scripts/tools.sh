#!/usr/bin/env bash
# Puts the tools of requirements/tools.in into .venv/tools, an environment of their own: what checks the FMU and builds the site.
# Costs nothing where they are there. With --optional it never fails: what is missing is named, and tests that need it are skipped.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"
. scripts/lib.sh
leave_foreign_ros_alone >/dev/null

python=$root/.venv/bin/python folder=$root/.venv/tools log=$root/out/logs/tools.log
[ -x "$python" ] || { echo "tools: run make setup first" >&2; exit 1; }
lock=requirements/lock-tools-py$("$python" -I -c 'import sys; print("%d%d" % sys.version_info[:2])').txt
[ "$(cat "$folder/done" 2>/dev/null)" = "$(digest "$lock")" ] && exit 0
mkdir -p "$(dirname "$log")"
echo "tools: fetching what checks the FMU and builds the site"
rm -rf "$folder"
if "$python" -m venv "$folder" >"$log" 2>&1 &&
  "$folder/bin/python" -m pip --disable-pip-version-check install --no-compile --progress-bar off --no-deps --require-hashes -r "$lock" >>"$log" 2>&1; then
  digest "$lock" >"$folder/done"
  exit 0
fi
rm -rf "$folder"
echo "tools: could not be installed, see ${log#"$root"/}; the site cannot be built, and the FMU's test is skipped" >&2
echo "tools: $(last_error "$log")" >&2
[ "${1:-}" = --optional ]
