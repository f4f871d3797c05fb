#!/usr/bin/env bash
# Puts the tools that the benchmark compares with into .venv/bench, a folder that nothing else
# looks into. What cannot be had is named in one line, and its rows are left out; never fails.
# FORTRAN=1 first installs the compiler that numbalsoda is built with (Debian, Ubuntu).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"
. scripts/lib.sh
leave_foreign_ros_alone

python=$root/.venv/bin/python folder=$root/.venv/bench logs=$root/out/logs
lock=requirements/lock-bench-py$("$python" -I -c 'import sys; print("%d%d" % sys.version_info[:2])').txt
stamp=$folder/done
[ "$(cat "$stamp" 2>/dev/null)" = "$(digest "$lock")" ] && exit 0
mkdir -p "$folder" "$logs"
rm -f "$folder"/*.reason "$stamp"

# One package with its hashes, out of the lock file.
pin() { awk -v name="$1" '$0 ~ "^" name "==" { on = 1 } on && /^[^ ]/ && $0 !~ "^" name "==" { exit } on && !/#/' "$lock"; }

if [ "${FORTRAN:-0}" = 1 ] && ! command -v gfortran >/dev/null; then
  as_root=$([ "$(id -u)" = 0 ] || echo sudo)
  echo "bench: installing gfortran"
  { $as_root apt-get update && $as_root apt-get install -y gfortran; } >"$logs/bench-gfortran.log" 2>&1 ||
    echo "bench: gfortran could not be installed, see out/logs/bench-gfortran.log"
fi

complete=1
for name in casadi filterpy numbalsoda; do
  log=$logs/bench-$name.log
  pin "$name" >"$folder/$name.txt"
  echo "bench: fetching $name"
  # Without what they depend on: numpy, scipy and numba are there, drawing is not needed.
  if "$python" -m pip --disable-pip-version-check install --no-deps --require-hashes --upgrade --target "$folder" \
    -r "$folder/$name.txt" >"$log" 2>&1; then
    continue
  fi
  complete=0
  if grep -q -e 'NewConnectionError' -e 'Temporary failure in name resolution' -e 'Network is unreachable' "$log"; then
    reason="could not be fetched, no network"
  elif grep -q 'No CMAKE_Fortran_COMPILER' "$log"; then
    reason="is built from source and needs a Fortran compiler: sudo apt-get install -y gfortran, or make bench FORTRAN=1"
  else
    reason="could not be installed, see ${log#"$root"/}: $(last_error "$log")"
  fi
  printf '%s\n' "$reason" >"$folder/$name.reason"
  echo "bench: $name $reason; its rows are left out"
done
[ "$complete" = 0 ] || digest "$lock" >"$stamp"
