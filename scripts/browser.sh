#!/usr/bin/env bash
# Chromium for the tests of the live page, where there is none and this user may install packages. Never fails: without a browser
# those tests are skipped, with the reason.
set -euo pipefail
for name in chromium chromium-browser google-chrome google-chrome-stable; do
  if command -v "$name" >/dev/null 2>&1; then exit 0; fi
done

by_hand="by hand: sudo apt-get install -y chromium"
if ! command -v apt-get >/dev/null 2>&1; then
  echo "browser: no Chromium and no apt-get here; the tests of the live page are skipped"
  exit 0
fi
as_root=
if [ "$(id -u)" != 0 ]; then
  if ! sudo -n true 2>/dev/null; then
    echo "browser: no Chromium, and installing one needs root; the tests of the live page are skipped - $by_hand"
    exit 0
  fi
  as_root="sudo -n"
fi
if grep -qs '^ID=ubuntu' /etc/os-release; then
  echo "browser: no Chromium; Ubuntu has it as a snap alone, which is left to you; the tests of the live page are skipped"
  exit 0
fi
echo "browser: installing Chromium for the tests of the live page"
log=$(mktemp)
if { $as_root apt-get update && DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y --no-install-recommends chromium; } >"$log" 2>&1; then
  rm -f "$log"
else
  echo "browser: could not be installed, the tests of the live page are skipped - $by_hand; the end of $log:"
  tail -n 3 "$log" | sed 's/^/  | /'
fi
