# Source this file (bash only): ROS, the workspace and its Python environment for the present shell.
#
#   source env.sh
#
# rosrun, roslaunch, rostopic and rostest then work in this shell. A ROS_MASTER_URI that is already set is kept, and so are
# ROS_IP and ROS_HOSTNAME; with neither, nodes of this shell are for this machine alone if its master is (docs/engineer/network.md).

_telex_root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd -P)"
if [ ! -f "$_telex_root/devel/setup.bash" ] || [ ! -x "$_telex_root/.venv/bin/python" ]; then
  echo "env.sh: the workspace is not built yet; run $_telex_root/launch_scripts/setup.sh first" >&2
  unset _telex_root
  return 1 2>/dev/null || exit 1
fi
# catkin's set-up file reads variables that may be unset
case $- in *u*) _telex_nounset=1; set +u ;; *) _telex_nounset= ;; esac
. "$_telex_root/devel/setup.bash"
[ -n "$_telex_nounset" ] && set -u
case ":$PATH:" in
  *":$_telex_root/.venv/bin:"*) ;;
  *) PATH="$_telex_root/.venv/bin:$PATH" ;;
esac
# a rosmaster, roscore and roslaunch that refuse web pages, before ROS's own
case ":$PATH:" in
  *":$_telex_root/src/telex_control/bin:"*) ;;
  *) PATH="$_telex_root/src/telex_control/bin:$PATH" ;;
esac
export PATH
# the suites that cross packages: rostest telex_tests station.test
case ":$ROS_PACKAGE_PATH:" in
  *":$_telex_root/tests:"*) ;;
  *) export ROS_PACKAGE_PATH="$_telex_root/tests:$ROS_PACKAGE_PATH" ;;
esac
# $(find xacro), for launch files and within xacro; last, so that a system's own goes first
case ":$ROS_PACKAGE_PATH:" in
  *":$_telex_root/ros_packages:"*) ;;
  *)
    export ROS_PACKAGE_PATH="$ROS_PACKAGE_PATH:$_telex_root/ros_packages"
    export PYTHONPATH="${PYTHONPATH:+$PYTHONPATH:}$_telex_root/ros_packages/xacro/src"
    ;;
esac
export ROS_MASTER_URI="${ROS_MASTER_URI:-http://localhost:11311}"
export ROS_DISTRO="${ROS_DISTRO:-noetic}"

if [ -z "${ROS_IP-}${ROS_HOSTNAME-}" ]; then
  unset ROS_IP ROS_HOSTNAME
  _telex_rest="${ROS_MASTER_URI#*://}"
  case "$_telex_rest" in
    \[*) # an IPv6 address
      _telex_rest="${_telex_rest#?}"
      _telex_host="${_telex_rest%%]*}"
      _telex_rest="${_telex_rest#*]}"
      ;;
    *)
      _telex_host="${_telex_rest%%[:/]*}"
      _telex_rest="${_telex_rest#"$_telex_host"}"
      ;;
  esac
  _telex_port="${_telex_rest#:}"
  _telex_port="${_telex_port%%[!0-9]*}"
  case "$_telex_host" in
    localhost | 127.0.0.1) export ROS_IP=127.0.0.1 ;;
    *)
      if [ "$_telex_host" = ::1 ] || "$_telex_root/.venv/bin/python" -c 'import sys; from rosgraph.network import is_local_address
sys.exit(not is_local_address(sys.argv[1]))' "$_telex_host"; then
        export ROS_IP=127.0.0.1
        # A master that is started here will be found at that address alone.
        if ! (exec 9<>"/dev/tcp/$_telex_host/${_telex_port:-11311}") 2>/dev/null; then
          export ROS_MASTER_URI="http://127.0.0.1:${_telex_port:-11311}"
          echo "env.sh: no master answers at $_telex_host, which is this machine: ROS_MASTER_URI is $ROS_MASTER_URI now;" \
            "set ROS_IP or ROS_HOSTNAME, too, to open ROS to other machines" >&2
        fi
      fi
      ;;
  esac
  unset _telex_host _telex_port _telex_rest
fi
unset _telex_root _telex_nounset
