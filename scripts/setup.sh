#!/usr/bin/env bash
# Makes .venv and the colcon workspace from what is locked; costs next to nothing when nothing
# has changed. Called by make; can be run by hand. DDH_PYTHON=python3.11 chooses the Python.
#   scripts/setup.sh --check       changes nothing, exits 1 and says so where something is to be done
#   scripts/setup.sh --packages    the environment without the workspace
#   scripts/setup.sh --tools       the tools of scripts/tools.sh --optional as well, fetched while the rest is made
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
venv=$root/.venv
state=$venv/ddh
logs=$root/out/logs
cd "$root"
. scripts/lib.sh

check_only=0 packages_only=0 with_tools=0
case "${1:-}" in
  "") ;;
  --check) check_only=1 ;;
  --packages) packages_only=1 ;;
  --tools) with_tools=1 ;;
  *) echo "setup: unknown argument '$1' (--check, --packages or --tools)" >&2; exit 2 ;;
esac

case "$root" in
  *[[:space:]:]*) echo "setup: the path of this checkout ($root) holds a space or a colon, which CMake and colcon cannot take; move it" >&2; exit 1 ;;
esac
leave_foreign_ros_alone

# --- prerequisites -----------------------------------------------------------------------------
missing=0
lack() { # what, apt package
  printf 'missing: %s - install it with: sudo apt-get install -y %s\n' "$1" "$2" >&2
  missing=1
}
works() { "$1" --version >/dev/null 2>&1; }

works git || lack "git" git
works make || lack "make" make
if ! works "${CXX:-c++}" && ! works g++ && ! works clang++; then lack "a C++ compiler" g++; fi

# An environment that is there and works keeps its Python, unless another is asked for.
if [ -z "${DDH_PYTHON:-}" ] && [ "$(cat "$state/root" 2>/dev/null)" = "$root" ] &&
  version=$("$venv/bin/python" -I -S -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null); then
  python_version=$version python=
else
  [ -n "${DDH_PYTHON:-}" ] || rm -f "$state/venv.done"
  find_python 12 11
  if [ -z "$python" ]; then
    if [ -n "${DDH_PYTHON:-}" ]; then
      printf 'missing: DDH_PYTHON=%s is no working Python 3.12 or 3.11 - leave it unset, or install one with: sudo apt-get install -y %s\n' \
        "$DDH_PYTHON" "$(apt_python)" >&2
      missing=1
    else
      lack "Python 3.12 or 3.11" "$(apt_python)"
    fi
  fi
  case ",$python_lacks," in *,venv,*) lack "venv for Python $python_version ($python)" "python$python_version-venv" ;; esac
  case ",$python_lacks," in *,dev,*) lack "C headers of Python $python_version ($python)" "python$python_version-dev" ;; esac
fi
[ "$missing" = 0 ] || exit 1

lock=requirements/lock-py${python_version/./}.txt

# --- one set-up at a time ----------------------------------------------------------------------
mkdir -p "$logs"
if command -v flock >/dev/null 2>&1; then
  exec 9>"$logs/setup.lock"
  flock -n 9 || { echo "setup: another one is at work here, waiting for it"; flock 9; }
fi

# --- steps -------------------------------------------------------------------------------------
make_venv() {
  rm -rf "$venv" ros2_ws/build ros2_ws/install
  "$python" -m venv "$venv"
  mkdir -p "$state"
  printf '%s\n' "$root" >"$state/root"
}
install_packages() {
  "$venv/bin/python" -m pip --disable-pip-version-check install --no-user --no-compile --progress-bar off --no-deps --require-hashes -r "$lock"
  # On all cores, which pip does not; what is no Python of this version among a package's files stays as it is.
  "$venv/bin/python" -m compileall -q -j 0 "$venv/lib" || true
  "$venv/bin/python" -I scripts/wheel_fixes.py
}
build() { # package
  (
    . "$state/env.sh"
    # Beneath the workspace lies the environment alone; python3 is its own.
    export AMENT_PREFIX_PATH=$venv PATH=$venv/bin:$PATH
    # As many jobs as cores; without this colcon sets a limit of load too, and two jobs of its own are enough to reach it.
    export MAKEFLAGS=-j$(nproc)
    cd ros2_ws
    COLCON_HOME=$state/colcon "$venv/bin/colcon" --log-base "$logs/colcon" build --symlink-install --packages-select "$1" \
      --event-handlers console_direct+ console_cohesion- \
      --cmake-args -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF -DPython3_EXECUTABLE="$venv/bin/python" -Wno-dev
  )
}
link_environment() { "$venv/bin/python" -I scripts/make_environment.py "$root"; }

if [ -n "$python" ]; then
  step venv "environment of Python $python_version" "$python $python_version $root" make_venv
fi
if [ "$with_tools" = 1 ]; then
  # Fetching and unpacking leave a core idle. It has its own log and lines; where it fails, the rest goes on.
  set -m # a process group of its own, so that it can be ended with all that it started
  scripts/tools.sh --optional </dev/null 9>&- &
  tools=$!
  set +m
  trap 'kill -- "-$tools" 2>/dev/null || true' EXIT
fi
step packages "packages of $lock" "$(digest "$lock" scripts/wheel_fixes.py)" install_packages
step environment "activation, ddh-twin command" "$(digest scripts/make_environment.py)$(cat "$state/packages.done")" link_environment
[ "$packages_only" = 0 ] || exit 0
step ddh_msgs "colcon build ddh_msgs" \
  "$(digest ddh_msgs/CMakeLists.txt ddh_msgs/package.xml ddh_msgs/msg/* ddh_msgs/srv/* ddh_msgs/action/*)$(cat "$state/packages.done")" build ddh_msgs
step ddh_twin_py "colcon build ddh_twin_py" \
  "$(digest ddh_twin_py/package.xml ddh_twin_py/setup.*)$(cd ddh_twin_py && find launch config -name '[!.]*' -not -path '*__pycache__*' 2>/dev/null | sort)$(cat "$state/ddh_msgs.done")" build ddh_twin_py
if [ "$with_tools" = 1 ]; then
  wait "$tools" || true
  trap - EXIT
fi
[ "$steps_done" = 0 ] || printf 'setup: ready after %s s. Next: . .venv/bin/activate\n' "$SECONDS"
