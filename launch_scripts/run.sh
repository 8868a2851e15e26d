#!/usr/bin/env bash
# Sets everything up, starts the whole simulator, and says where the console is.
#
#   ./launch_scripts/run.sh [roslaunch arguments, e.g. gui:=true video_port:=8081]
#
# Ctrl-C ends it all. A running ROS master (ROS_MASTER_URI) is used; without one, one is started.
set -uo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
case "${1:-}" in
  -h | --help)
    sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac
"$root/launch_scripts/setup.sh" || exit 1
# shellcheck disable=SC1091
. "$root/env.sh" || exit 1

namespace=telex
expected=()
for argument in "$@"; do
  case "$argument" in
    ns:=*) namespace="${argument#ns:=}" ;;
    console:=false) expected+=(--no-console) ;;
    cameras:=false) expected+=(--no-picture) ;;
  esac
done

launch_pid=
children_of() { ps -o pid= --ppid "$1" 2>/dev/null; }

# All descendants of a process. roslaunch's nodes lead groups of their own, so a group is not enough.
descendants() {
  local child
  for child in $(children_of "$1"); do
    echo "$child"
    descendants "$child"
  done
}

# Ends what this script started and nothing else: asks first, then insists, within 5 s.
stop() {
  trap '' INT TERM HUP
  [ -n "$launch_pid" ] || return
  local pids pid waited
  pids="$(descendants "$launch_pid")"
  printf '\nStopping the simulator ...\n'
  kill -INT "$launch_pid" 2>/dev/null
  for waited in $(seq 1 40); do
    kill -0 "$launch_pid" 2>/dev/null || break
    sleep 0.1
  done
  for pid in $launch_pid $pids; do kill -KILL "$pid" 2>/dev/null; done
  wait "$launch_pid" 2>/dev/null
  launch_pid=
  printf 'The simulator has ended.\n'
}
trap 'stop; exit 130' INT
trap 'stop; exit 143' TERM HUP
trap stop EXIT

echo "Starting the simulator ..."
# Its own session, so that Ctrl-C reaches this script alone, which then ends the rest in order.
setsid roslaunch --no-summary --sigint-timeout=1.5 --sigterm-timeout=1.0 telex_teleop bringup.launch "$@" &
launch_pid=$!

python "$root/launch_scripts/wait_ready.py" --namespace "$namespace" --launch-pid "$launch_pid" \
  "${expected[@]}" &
waiter=$!
wait "$waiter" || { echo "run.sh: the simulator did not start; the messages above say why" >&2; exit 1; }

wait "$launch_pid"
status=$?
launch_pid=
exit "$status"
