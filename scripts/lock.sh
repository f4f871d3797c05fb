#!/usr/bin/env bash
# Writes requirements/lock-py312.txt and lock-py311.txt from the .in files, lock-bench-py312.txt and lock-bench-py311.txt (what
# `make bench` compares with) from bench.in, lock-tools-py312.txt and lock-tools-py311.txt (what checks the FMU and builds the
# site) from tools.in, each with the Python that it is for: every package, direct or not, with its version and hashes.
# A package may ask for a patch version of Python (>= 3.11.5), so each lock is made with a Python that is no newer than the
# oldest that it has to serve: 3.11.2 of Debian 12, 3.12.3 of Ubuntu 24.04.
# Keeps what is locked where the .in files still allow it; --upgrade takes the newest.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root/requirements"
. ../scripts/lib.sh
leave_foreign_ros_alone
oldest_11=3.11.2 oldest_12=3.12.3

python_for_lock() { # minor version, oldest that is served; sets python to the first of this machine that is no newer
  local candidate version found=
  python=
  while read -r candidate; do
    version=$("$candidate" -I -c 'import venv, ensurepip, sys; print("%d.%d.%d" % sys.version_info[:3])' 2>/dev/null) || continue
    case "$version" in 3."$1".*) ;; *) continue ;; esac
    found="$found $version"
    [ "$(printf '%s\n' "$version" "$2" | sort -V | tail -n 1)" = "$2" ] && python=$candidate && return
  done < <([ -z "${DDH_PYTHON:-}" ] || printf '%s\n' "$DDH_PYTHON"; DDH_PYTHON= candidates "$1")
  echo "lock: needs a Python 3.$1 with venv that is no newer than $2, found:${found:- none}; DDH_PYTHON=... names another" >&2
  exit 1
}

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
for minor in 12 11; do
  oldest=oldest_$minor
  python_for_lock "$minor" "${!oldest}"
  echo "lock: resolving for Python ${!oldest} and newer ($python), takes 1 to 3 min"
  "$python" -m venv "$scratch/$minor"
  "$scratch/$minor/bin/pip" --disable-pip-version-check -q install pip-tools==7.6.2
  # No trace of where the packages came from: the same lock serves any index.
  CUSTOM_COMPILE_COMMAND=scripts/lock.sh "$scratch/$minor/bin/pip-compile" -q "$@" --generate-hashes --allow-unsafe \
    --strip-extras --no-emit-index-url --no-emit-find-links --no-emit-trusted-host \
    -o "lock-py3$minor.txt" ros.in twin.in dev.in
  # What both need has one version: the twin's.
  CUSTOM_COMPILE_COMMAND=scripts/lock.sh "$scratch/$minor/bin/pip-compile" -q "$@" --generate-hashes --allow-unsafe \
    --strip-extras --no-emit-index-url --no-emit-find-links --no-emit-trusted-host \
    -c "lock-py3$minor.txt" -o "lock-bench-py3$minor.txt" bench.in
  CUSTOM_COMPILE_COMMAND=scripts/lock.sh "$scratch/$minor/bin/pip-compile" -q "$@" --generate-hashes --allow-unsafe \
    --strip-extras --no-emit-index-url --no-emit-find-links --no-emit-trusted-host \
    -o "lock-tools-py3$minor.txt" tools.in
  for lock in "lock-py3$minor.txt" "lock-bench-py3$minor.txt" "lock-tools-py3$minor.txt"; do
    grep -c '^[a-zA-Z0-9].*==' "$lock" | sed "s/^/lock: $lock: /; s/\$/ packages/"
  done
done
