#!/bin/sh
# Runs a node of ddh_twin_py by its name, or any other command, in the twin's environment.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd -P)
. "$root/.venv/ddh/env.sh"
export PATH="$root/.venv/bin:$PATH"
node=$root/ros2_ws/install/ddh_twin_py/lib/ddh_twin_py/${1:-ddh-twin}
if [ -x "$node" ]; then
  shift
  exec "$node" "$@"
fi
exec "$@"
