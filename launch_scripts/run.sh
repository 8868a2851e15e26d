#!/usr/bin/env bash
# Sets everything up, starts the whole simulator, and says where the console is.
#
#   ./launch_scripts/run.sh [roslaunch arguments, e.g. world:=stairs video_port:=8081, or exercise:=slalom operator:=ann]
#
# replay:=FILE shows the recording of a trial again, without a simulator.
# robots:=2, or names or variants with commas between, puts several robots into the scene (docs/operator/two_robots.md).
# model:=URDF_OR_XACRO controllers:=FILE ... starts a robot of your own in the place of Telex (docs/engineer/own_robot.md).
# class:=FILE shows the stations of a class on one page, without ROS (docs/instructor/class.md).
# Without world:= it starts in the training hall, without speed:= with 35 % of the speed.
# ros_address:=NAME_OR_ADDRESS opens ROS to other machines, which know this one by it (docs/engineer/network.md).
# Ctrl-C ends it all. A running ROS master (ROS_MASTER_URI, or -p PORT) is used; without one, one is started.
set -uo pipefail
# Also while a program is waited for that takes the signal in its own way, as the set-up does.
trap 'exit 130' INT

root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
case "${1:-}" in
  -h | --help)
    sed -n '2,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
esac

# roslaunch passes over what no launch file asks for: a misspelt name would go unnoticed.
launch_file=telex_training/launch/station.launch
any_files='actions joy_map'
own_files="$any_files model controllers config base arm gripper flippers cameras lamps"
for argument in "$@"; do
  case "$argument" in
    replay:=*) launch_file=telex_training/launch/replay.launch ;;
    class:=*) launch_file= ;;
    model:=*) launch_file=telex_teleop/launch/own_robot.launch ;;
  esac
done
if [ -n "$launch_file" ]; then
  known="$(sed -n 's/^  <arg name="\([a-z_]*\)".*/\1/p' "$root/src/$launch_file")"
  known+=$'\nros_address'
  case "$launch_file" in
    */station.launch) known+=$'\nreplay\nclass\nrobots\nmodel' ;;
    */replay.launch) known+=$'\nreplay\nclass' ;;
  esac
else
  known=$'class\nclass_port\naddress\ntoken_file'
fi
takes_value=
master_port=
for argument in "$@"; do
  if [ -n "$takes_value" ]; then
    case "$takes_value" in -p | --port) master_port="$argument" ;; esac
    takes_value=
    continue
  fi
  case "$argument" in
    -p?*) master_port="${argument#-p}" ;;
    --port=*) master_port="${argument#--port=}" ;;
    -[cptuw] | --args | --child | --find-node | --master-logger-level | --numworkers | --pid | --port | --run_id | \
      --server_uri | --sigint-timeout | --sigterm-timeout | --timeout) takes_value="$argument" ;;
    -*) ;;
    token:=* | instructor_token:=*)
      printf 'run.sh: %s:= is gone, for all users of this machine can read a command line: write the token into a file, and give %s_file:=FILE (without such a file, one is made)\n' \
        "${argument%%:=*}" "${argument%%:=*}" >&2
      exit 2
      ;;
    *)
      name="${argument%%:=*}"
      if [ "$name" != "$argument" ] && grep -qxF -- "$name" <<<"$known"; then
        # roslaunch passes over an empty value, too, and takes the default.
        [ "$argument" = "$name:=" ] && grep -q "^  <arg name=\"$name\" default=\"[^\"]" "$root/src/$launch_file" 2>/dev/null || continue
        echo "run.sh: $argument has no value; leave it out, or give one" >&2
        exit 2
      fi
      # shellcheck disable=SC2086
      printf "run.sh: unknown argument '%s'; there are: %s\n" "$argument" "$(printf '%s:= ' $known)" >&2
      exit 2
      ;;
  esac
done

if [ -n "$master_port" ]; then
  if [[ ! "$master_port" =~ ^[1-9][0-9]{0,4}$ ]] || [ "$master_port" -gt 65535 ]; then
    echo "run.sh: the master's port is '$master_port'; 1 to 65535 are possible" >&2
    exit 2
  fi
  # roslaunch starts the master there, or takes the one that runs there; all that waits for it must know.
  export ROS_MASTER_URI="http://localhost:$master_port"
fi

"$root/launch_scripts/setup.sh" || exit 1
# roslaunch would put the robot's namespace below it.
unset ROS_NAMESPACE
ros_address=
for argument in "$@"; do
  case "$argument" in ros_address:=*) ros_address="${argument#*:=}" ;; esac
done
case "$ros_address" in
  '') ;;
  localhost | 127.*) unset ROS_HOSTNAME; export ROS_IP=127.0.0.1 ;;
  *) unset ROS_IP; export ROS_HOSTNAME="$ros_address" ;;  # ROS takes an address for it, too
esac
# shellcheck disable=SC1091
. "$root/env.sh" || exit 1
if [ -z "$launch_file" ]; then
  file=
  arguments=()
  for argument in "$@"; do
    value="${argument#*:=}"
    case "$argument" in
      class:=*) file="${value/#\~\//$HOME/}" ;;
      class_port:=*) arguments+=(--port "$value") ;;
      address:=*) arguments+=(--address "$value") ;;
      token_file:=*) arguments+=(--token-file "${value/#\~\//$HOME/}") ;;
    esac
  done
  exec "$root/src/telex_training/nodes/class" "${arguments[@]}" -- "$file"
fi
if [ -n "$ros_address" ]; then
  python -c 'import sys; from rosgraph.network import is_local_address
sys.exit(sys.argv[1].startswith("0.") or not is_local_address(sys.argv[1]))' "$ros_address" || {
    echo "run.sh: ros_address:=$ros_address is no name or address of this machine; give the one by which others know it" >&2
    exit 2
  }
fi
case "${ROS_HOSTNAME:-${ROS_IP:-$(hostname)}}" in
  localhost | 127.*) ;;
  *)
    cat >&2 <<END
run.sh: ROS is open: who reaches this machine at ${ROS_HOSTNAME:-${ROS_IP:-$(hostname)}} can drive the robot, change and end everything,
  without a token and past the bridge. Only for a network on which you trust everybody (docs/engineer/network.md).
END
    ;;
esac
# Into a file, too, nodes say at once what they have to say.
export PYTHONUNBUFFERED=1

# What robots:= says becomes other arguments.
robots=
first=telex
variant=standard
address=127.0.0.1
declare -A files=()
for argument in "$@"; do
  case "$argument" in
    robots:=*) robots="$argument" ;;
    address:=*) address="${argument#address:=}" ;;
    token_file:=?* | instructor_token_file:=?*) files["${argument%%:=*}"]=given ;;
    ns:=*) first="${argument#ns:=}" ;;
    variant:=*) variant="${argument#variant:=}" ;;
  esac
done
names=
if [ -n "$robots" ]; then
  told="$(python "$root/launch_scripts/robots.py" "${robots#robots:=}" "$first" "$variant")" || exit 2
  names="${told##*$'\n'}"
  told="${told%$'\n'*}"
  case "$address" in
    localhost | 127.*) ;;
    *)
      # Else each bridge would make tokens of its own, and no instructor's page could reach them all.
      if [[ "$names" == *\ * ]] && [ "${#files[@]}" -lt 2 ]; then
        echo "run.sh: $robots with address:=$address needs token_file:=FILE and instructor_token_file:=FILE, which all bridges share (they are made if absent)" >&2
        exit 2
      fi
      ;;
  esac
  mapfile -t told <<<"$told"
  set -- "$@" "${told[@]}"
fi

is_false() { case "${1,,}" in 0 | false) return 0 ;; *) return 1 ;; esac; }
namespace=telex
expected=()
# A later argument of the same name counts.
arguments=(world:=training_hall speed:=0.35)
is_own=
case "$launch_file" in
  */replay.launch)
    arguments=()
    expected+=(--replay)
    ;;
  */own_robot.launch)
    arguments=()
    namespace=robot
    is_own=yes
    ;;
esac
teleop=()
has_cameras=
for argument in "$@"; do
  name="${argument%%:=*}"
  # Nodes do not run in the caller's folder, and the shell leaves a tilde behind := alone.
  if [[ " ${is_own:+$own_files} $any_files " == *" $name "* ]] && [ "$argument" != "$name:=" ]; then
    file="${argument#*:=}"
    file="$(realpath -m -- "${file/#\~\//$HOME/}")"
    if [ ! -f "$file" ]; then
      echo "run.sh: $argument: there is no file $file" >&2
      exit 2
    fi
    arguments+=("$name:=$file")
    case "$name" in
      base) teleop+=(track_teleop) ;;
      arm | gripper) teleop+=("${name}_teleop") ;;
      flippers) teleop+=(flipper_teleop) ;;
      cameras) has_cameras=yes ;;
    esac
    continue
  fi
  case "$argument" in
    world:=*/* | world:=*.yaml | exercise:=*/* | exercise:=*.yaml | recordings:=?* | variant:=*/* | variant:=*.yaml | robot:=*/* | token_file:=?* | instructor_token_file:=?*)
      file="${argument#*:=}"
      argument="${argument%%:=*}:=$(realpath -m -- "${file/#\~\//$HOME/}")"
      ;;
    replay:=*)
      file="${argument#*:=}"
      argument="file:=$(realpath -m -- "${file/#\~\//$HOME/}")"
      ;;
    ros_address:=* | robots:=*) continue ;;
    ns:=*) namespace="${argument#ns:=}" ;;
    console:=*) is_false "${argument#console:=}" && expected+=(--no-console) ;;
    cameras:=*) is_false "${argument#cameras:=}" && expected+=(--no-picture) ;;
  esac
  arguments+=("$argument")
done
expected+=(--namespace "$namespace")
if [ -n "$is_own" ]; then
  expected+=(--own-robot "${teleop[*]}")
  [ -n "$has_cameras" ] || expected+=(--no-picture)
fi
for name in $names; do
  [ "$name" = "$namespace" ] || expected+=(--beside "$name")
done

# Whatever is started here carries this mark in its environment, so that nothing else is ever ended.
mark="TELEX_RUN=$$-$(date +%s%N)"
launch_pid=
started() { grep -lszxF "$mark" /proc/[0-9]*/environ 2>/dev/null | cut -d/ -f3; }

# Asks everything to end for 3 s, then insists. roslaunch, when it may, ends its nodes in order.
stop() {
  # PIPE as well: what reads the output may have ended by the same Ctrl-C.
  trap '' INT TERM HUP PIPE
  [ -n "$launch_pid" ] || return
  printf '\nStopping the simulator ...\n'
  # By a clock, in ms: on a busy machine each look at all processes takes its time.
  local left passed=0 asked=0
  local -r began="${EPOCHREALTIME/[.,]/}"
  while left="$(started)"; [ -n "$left" ] && [ "$passed" -lt 15000 ]; do
    if [ "$passed" -ge 3000 ]; then
      # shellcheck disable=SC2086
      kill -KILL $left 2>/dev/null
    elif kill -0 "$launch_pid" 2>/dev/null; then
      # Again and again: a program that is just being started does not hear the first one.
      if [ "$passed" -ge "$asked" ]; then
        kill -INT "$launch_pid" 2>/dev/null
        asked=$((passed + 1000))
      fi
    else
      # shellcheck disable=SC2086
      kill -TERM $left 2>/dev/null
    fi
    sleep 0.1
    passed=$(((${EPOCHREALTIME/[.,]/} - began) / 1000))
    # The shell tells of what it sees killed.
  done 2>/dev/null
  wait 2>/dev/null
  launch_pid=
  printf 'The simulator has ended.\n'
}
trap 'stop; exit 130' INT
trap 'stop; exit 143' TERM HUP
trap stop EXIT

node="$(python "$root/launch_scripts/running.py" "$namespace")" || {
  echo "run.sh: $node runs already on the ROS master $ROS_MASTER_URI, and two simulators on one end each other:" \
    "end that one, or start this one with -p 11312 video_port:=0 bridge_port:=0" >&2
  exit 2
}
echo "Starting the simulator ..."
# A session of its own, so that Ctrl-C reaches this script alone, which then ends the rest in order. The
# shell starts background jobs deaf to SIGINT; roslaunch must hear it.
env "$mark" setsid python -c '
import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)
os.execvp(sys.argv[1], sys.argv[1:])
' roslaunch --no-summary --sigint-timeout=1.5 --sigterm-timeout=1.0 "${launch_file%%/*}" "${launch_file##*/}" "${arguments[@]}" &
launch_pid=$!

env "$mark" python "$root/launch_scripts/wait_ready.py" --launch-pid "$launch_pid" \
  "${expected[@]}" &
wait $! || {
  echo "run.sh: the simulator did not start; the messages above say why" >&2
  exit 1
}

wait "$launch_pid"
echo "run.sh: the simulator has ended by itself; the messages above say why" >&2
exit 1
