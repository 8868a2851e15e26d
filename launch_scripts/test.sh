#!/usr/bin/env bash
# Sets everything up and runs every check and test.
#
#   ./launch_scripts/test.sh [--fast] [pytest arguments]
#
# --fast: lint, types and what is quick and needs no ROS master, browser or wall time.
# Further arguments go to pytest (-n 0: all tests in one process, as --pdb wants it).
set -uo pipefail

root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
cd "$root" || exit 1
fast=
pytest_arguments=()
for argument in "$@"; do
  case "$argument" in
    --fast) fast=1 ;;
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) pytest_arguments+=("$argument") ;;
  esac
done

"$root/launch_scripts/setup.sh" --test || exit 1
# shellcheck disable=SC1091
. "$root/env.sh" || exit 1
# Whatever master the user has running is not to be disturbed: each test starts its own.
export ROS_MASTER_URI=http://127.0.0.1:9
export ROS_IP=127.0.0.1
# And what this shell has set for Python is not to hide what a plain one lacks, nor to have every
# process compile its modules anew: a third of the time of --fast.
unset ROS_HOSTNAME PYTHONUNBUFFERED PYTHONDONTWRITEBYTECODE

# make_folder: prints a new folder for what the tests write and nobody keeps. It lies in memory where
# there is room: on a busy disk the browsers' tests take a third longer.
make_folder() {
  local memory=/dev/shm free folder
  free="$(df --output=avail "$memory" 2>/dev/null | tail -n 1)"
  if [ "${free:-0}" -ge 2097152 ] && folder="$(mktemp -d -p "$memory" telex-test.XXXXXX 2>/dev/null)"; then
    # Tests write programs and run them, which some systems forbid there.
    if printf '#!/bin/sh\n' >"$folder/run" && chmod +x "$folder/run" && "$folder/run" 2>/dev/null; then
      rm "$folder/run"
      printf '%s\n' "$folder"
      return
    fi
    rm -r "$folder"
  fi
  mktemp -d -t telex-test.XXXXXX
}

folder="$(make_folder)" || exit 1
trap 'rm -rf "$folder"' EXIT
export TMPDIR="$folder/tmp"
export ROS_LOG_DIR="$folder/log"
mkdir "$TMPDIR" "$ROS_LOG_DIR" || exit 1
failed=

# begin NAME TITLE COMMAND...: runs a check in the background.
begin() {
  local name="$1" started=$SECONDS
  printf '%s\n' "$2" >"$folder/$name.title"
  shift 2
  (
    # Tests in wall time are not to be held up by it; --fast has none of them.
    [ -n "$fast" ] || renice -n 10 "$BASHPID" >/dev/null
    "$@" >"$folder/$name.out" 2>&1
    printf '%s %s\n' $? $((SECONDS - started)) >"$folder/$name.part"
    mv "$folder/$name.part" "$folder/$name.end"
  ) &
  pids[$name]=$!
}

# end NAME: waits for it, and notes whether something is wrong.
end() {
  local rc=1
  wait "${pids[$1]}"
  read -r rc _ <"$folder/$1.end"
  [ "$rc" -eq 0 ] || failed=1
}

declare -A pids
javascript="$root/src/telex_teleop/test/javascript"
page_checks() {
  "$javascript/node_modules/.bin/tsc" --project "$javascript" &&
    env -C "$javascript" node --test --test-reporter=spec
}
type_checks() {
  # What makes the docs' pictures is run too seldom to show when the product has left it behind.
  mypy && mypy --scripts-are-modules "$root"/docs/make_*
}
# They go on beside pytest, which tells how they went before its closing line: that comes last.
begin lint "ruff (lint)" ruff check
begin format "ruff (format)" ruff format --check --quiet
begin page "tsc and node --test (the page's JavaScript)" page_checks
begin mypy "mypy" type_checks
export TELEX_CHECKS_BESIDE="$folder"
if [ -n "$fast" ]; then
  pytest_arguments=(-m "not (ros or browser or real_time or slow)" --durations=5 "${pytest_arguments[@]}")
fi

# What works hard in wall time, what waits in wall time, and, at low priority, what needs none: each
# has workers of its own; conftest.py says which.
workers=$(($(nproc) + 1))
# Without those that wait, one more would only import everything once more.
[ -z "$fast" ] || workers=$(nproc)
[ "$workers" -le 5 ] || workers=5
[ "$(nproc)" -eq 1 ] || pytest_arguments=(-n "$workers" --dist loadgroup "${pytest_arguments[@]}")

python -m pytest "${pytest_arguments[@]}"
status=$?
for name in lint format page mypy; do end "$name"; done
[ -z "$failed" ] || exit 1
exit $status
