#!/usr/bin/env bash
# Sets everything up, repeats the paper's results on the running system, and writes results/report.html.
#
#   ./launch_scripts/reproduce_paper.sh [--quick] [--only NAME ...] [--out DIR] [--seed N] [--repeat N] [--list]
#
# --quick: a coarse answer in some minutes. --only: these experiments only (--list names them).
# --out: where the results go, in place of results/. Exit status 1: a result misses its bar.
# --repeat: the paths of figure 8 so often, every second time beside hogs, and their joint states compared.
# Ctrl-C ends everything.
set -uo pipefail

root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
for argument in "$@"; do
  case "$argument" in
    -h | --help)
      sed -n '2,9s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit 0
      ;;
  esac
done
# Chromium, for the picture of the console, is among what only the tests need.
"$root/launch_scripts/setup.sh" --test || exit 1
# shellcheck disable=SC1091
. "$root/env.sh" || exit 1
# Whatever master the user has running is not to be disturbed: each experiment starts its own.
export ROS_MASTER_URI=http://127.0.0.1:9
unset ROS_HOSTNAME ROS_IP ROS_NAMESPACE
exec python -m telex_experiments.paper "$@"
