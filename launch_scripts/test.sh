#!/usr/bin/env bash
# Sets everything up and runs every check and test.
#
#   ./launch_scripts/test.sh [--fast] [pytest arguments]
#
# --fast: lint, types and what is quick and needs no ROS master, browser or wall time: under a minute.
# Further arguments go to pytest (-n 0: all tests in one process, as --pdb wants it).
set -uo pipefail

root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd)"
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
unset ROS_HOSTNAME
ROS_LOG_DIR="$(mktemp -d)"
export ROS_LOG_DIR
export ROS_TEST_RESULTS_DIR="$ROS_LOG_DIR/test_results"
trap 'rm -rf "$ROS_LOG_DIR"' EXIT
failed=()

# check TITLE COMMAND...
check() {
  local title="$1" started=$SECONDS
  shift
  printf '\n== %s\n' "$title"
  if "$@"; then
    printf '== %s: ok (%d s)\n' "$title" $((SECONDS - started))
  else
    printf '== %s: FAILED (%d s)\n' "$title" $((SECONDS - started))
    failed+=("$title")
  fi
}

check "ruff (lint)" ruff check
check "ruff (format)" ruff format --check --quiet
check "mypy" mypy
if [ -z "$fast" ]; then
  for suite in tests/rostest/*.test src/*/test/*.test; do
    [ -e "$suite" ] || continue
    # rostest starts a master of its own on a free port.
    check "rostest $suite" rostest "$suite"
  done
else
  pytest_arguments=(-m "not (ros or browser or real_time or slow)" --durations=5 "${pytest_arguments[@]}")
fi

# Tests that need no wall time run beside those that do, at low priority; conftest.py says which.
workers="$(nproc)"
[ "$workers" -le 4 ] || workers=4
[ "$workers" -eq 1 ] || pytest_arguments=(-n "$workers" --dist loadgroup "${pytest_arguments[@]}")

# pytest comes last, so that its closing line counts the tests.
if [ ${#failed[@]} -gt 0 ]; then printf '\nFailed so far: %s\n' "${failed[*]}"; fi
printf '\n== pytest\n'
python -m pytest "${pytest_arguments[@]}"
status=$?
[ ${#failed[@]} -eq 0 ] || exit 1
exit $status
