# Sourced by the other scripts: foreign ROS, stamps, progress.

# A ROS 2 that happens to be sourced is another one than ours: out of this process, untouched in the shell.
leave_foreign_ros_alone() {
  case "${AMENT_PREFIX_PATH:-}" in
    "$root"/*) ;; # our own, activated
    "")
      if [ -n "${ROS_DISTRO:-}" ]; then
        echo "note: ROS 2 $ROS_DISTRO is set up in this shell; it is left alone and not used here"
      elif [ -n "${PYTHONPATH:-}" ]; then
        echo "note: PYTHONPATH is set in this shell; it is left alone and not used here"
      fi
      ;;
    *) echo "note: ROS 2 ${ROS_DISTRO:-} is sourced in this shell (${AMENT_PREFIX_PATH%%:*}); it is left alone and not used here" ;;
  esac
  unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH COLCON_CURRENT_PREFIX COLCON_DEFAULTS_FILE \
    ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION RMW_IMPLEMENTATION PYTHONPATH PYTHONHOME LD_LIBRARY_PATH \
    PKG_CONFIG_PATH VIRTUAL_ENV _ROS_WHEELS_BOOTSTRAP_COMPLETE
}

# A working Python: runs (the shims of pyenv exist and may not), can make a venv, has the headers that the messages'
# extension modules are compiled against. Prints "version executable" or nothing.
python_probe='
import os, sys, sysconfig
version = sys.version_info[:2]
missing = []
try: import venv, ensurepip
except ImportError: missing.append("venv")
if not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")): missing.append("dev")
print("%d.%d" % version, ",".join(missing) or "complete", sys.executable)
'
candidates() { # minor versions, best first
  if [ -n "${DDH_PYTHON:-}" ]; then
    printf '%s\n' "$DDH_PYTHON"
    return
  fi
  local minor
  for minor in "$@"; do
    type -aP "python3.$minor" || true
    ls -d "${PYENV_ROOT:-${HOME:-/root}/.pyenv}"/versions/3."$minor"*/bin/python3 2>/dev/null | sort -rV || true
    type -aP python3 || true
  done
}
find_python() { # minor versions, best first; sets python, python_version, python_lacks
  python= python_version= python_lacks=
  local candidate version lacks executable
  while read -r candidate; do
    read -r version lacks executable < <("$candidate" -I -c "$python_probe" 2>/dev/null) || continue
    case " $* " in *" ${version#3.} "*) ;; *) continue ;; esac
    if [ "$lacks" = complete ]; then
      python=$executable python_version=$version python_lacks=
      return
    fi
    [ -n "$python" ] || python=$executable python_version=$version python_lacks=$lacks
  done < <(candidates "$@")
}

apt_python() { # what this machine's distribution calls it
  if grep -qs 'VERSION_CODENAME=bookworm' /etc/os-release; then
    echo "python3 python3-venv python3-dev"
  else
    echo "python3.12 python3.12-venv python3.12-dev"
  fi
}

digest() { cat "$@" | sha256sum | cut -c1-32; }

# The last line of a log in which pip says what is wrong, else its last line that says anything.
last_error() { # log
  { grep -a '^ *\(ERROR\|error\):' "$1" || grep -a '[^[:space:]]' "$1"; } 2>/dev/null | tail -n 1 | tr -d '\r' | cut -c1-300 || true
}

# step NAME LABEL INPUTS COMMAND...: skipped while INPUTS are what they were when it last succeeded.
steps_done=0
step() {
  local name=$1 label=$2 inputs=$3 stamp log started=$SECONDS reporter status stopped=0
  shift 3
  stamp=$state/$name.done
  if [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$inputs" ]; then return; fi
  steps_done=$((steps_done + 1))
  if [ "${check_only:-}" = 1 ]; then
    echo "setup: not up to date: $label - run: make setup" >&2
    exit 1
  fi
  log=$logs/setup-$name.log
  rm -f "$stamp"
  report "$label" "$log" "$started" &
  reporter=$!
  # The command stays in the foreground, so that Ctrl-C reaches it and all that it started.
  # Not in a list with ||, which would switch off the "set -e" of the subshell.
  set +e
  trap 'stopped=1' INT
  (set -e; "$@") >"$log" 2>&1 </dev/null 9>&-
  status=$?
  trap - INT
  set -e
  kill "$reporter" 2>/dev/null || true
  wait "$reporter" 2>/dev/null || true
  [ -t 1 ] && printf '\r\033[K'
  if [ "$stopped" = 1 ]; then
    echo "setup: stopped; the next make goes on from here" >&2
    exit 130
  fi
  if [ "$status" != 0 ]; then
    printf 'setup: %s failed after %s s; the end of %s:\n' "$label" "$((SECONDS - started))" "${log#"$root"/}" >&2
    tail -n 25 "$log" | sed 's/^/  | /' >&2
    exit 1
  fi
  mkdir -p "$state"
  printf '%s' "$inputs" >"$stamp"
  printf 'setup: %s: done in %s s\n' "$label" "$((SECONDS - started))"
}

# What a step is doing and for how long, from the last line of its log: in place on a terminal,
# otherwise a line when it starts and one every 15 s.
report() {
  local label=$1 log=$2 started=$3 pause=1 line
  exec 9>&-
  trap 'exit 0' TERM
  if [ ! -t 1 ]; then
    printf 'setup: %s ...\n' "$label"
    pause=15
  fi
  while kill -0 $$ 2>/dev/null; do
    if [ -t 1 ]; then
      line=$(tail -n 1 "$log" 2>/dev/null | tr -d '\r' | cut -c1-60)
      printf '\r\033[Ksetup: %s, %s s  %s' "$label" "$((SECONDS - started))" "$line"
      sleep "$pause"
    else
      sleep "$pause" & wait $!
      line=$(tail -n 1 "$log" 2>/dev/null | tr -d '\r' | cut -c1-60)
      printf 'setup: %s, %s s so far: %s\n' "$label" "$((SECONDS - started))" "$line"
    fi
  done
}
