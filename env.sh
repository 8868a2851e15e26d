# Source this file (bash only): ROS, the workspace and its Python environment for the present shell.
#
#   source env.sh
#
# rosrun, roslaunch, rostopic and rostest then work in this shell. A ROS_MASTER_URI that is already set is kept.

_telex_root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)"
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
export PATH
# the suites that cross packages: rostest telex_tests end_to_end.test
case ":$ROS_PACKAGE_PATH:" in
  *":$_telex_root/tests:"*) ;;
  *) export ROS_PACKAGE_PATH="$_telex_root/tests:$ROS_PACKAGE_PATH" ;;
esac
export ROS_MASTER_URI="${ROS_MASTER_URI:-http://localhost:11311}"
export ROS_DISTRO="${ROS_DISTRO:-noetic}"
unset _telex_root _telex_nounset
