#!/usr/bin/env bash
# Makes everything that the simulator needs: system packages, Python environment, catkin build.
#
#   ./launch_scripts/setup.sh [--test]
#
# --test adds what only the tests need. What is done already is skipped. run.sh and test.sh call this.
set -euo pipefail

root="$(CDPATH= cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
state="$root/.setup"
log="$state/setup.log"
with_tests=
for argument in "$@"; do
  case "$argument" in
    --test) with_tests=1 ;;
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    *) echo "setup.sh: unknown argument '$argument'; only --test is known" >&2; exit 2 ;;
  esac
done
if ! mkdir -p "$state" 2>/dev/null || [ ! -w "$state" ] || [ ! -w "$root" ]; then
  echo "setup.sh: $root cannot be written; was it set up by another user? chown -R \"\$USER\" '$root'" >&2
  exit 1
fi
# Two set-ups at once would spoil each other's build.
exec 8>"$state/lock"
flock -n 8 || { echo "Another set-up is running in $root; waiting for it ..."; flock 8; }

# fail STEP WHY WHAT_TO_DO
fail() {
  printf '\nsetup.sh: %s failed: %s\n  What to do: %s\n' "$1" "$2" "$3" >&2
  exit 1
}

# Set while steps run that must not be broken off.
finishes=
# step TITLE WHAT_TO_DO COMMAND...: runs it with a running clock, output to the log, its end shown when it fails.
step() {
  local title="$1" remedy="$2" started status=0 last pid
  shift 2
  started=$SECONDS
  printf '%s ...' "$title"
  printf '\n==== %s: %s\n' "$title" "$*" >>"$log"
  if [ -n "$finishes" ]; then
    # A package manager that is killed half-way leaves a broken system.
    "$@" >>"$log" 2>&1 8>&- &
    pid=$!
    # Its terminal may be gone.
    trap 'printf "\nInterrupted; waiting for the package manager to finish ...\n" 2>/dev/null || :; wait "$pid"; exit 130' INT TERM HUP
  else
    # A session of its own, so that all of its children end with it.
    setsid "$@" >>"$log" 2>&1 8>&- &
    pid=$!
    trap 'kill -TERM -- "-$pid" 2>/dev/null; wait "$pid" 2>/dev/null; exit 130' INT TERM HUP
  fi
  while kill -0 "$pid" 2>/dev/null; do
    sleep 0.2
    [ -t 1 ] && printf '\r%s ... %d s ' "$title" $((SECONDS - started))
  done
  wait "$pid" || status=$?
  trap - INT TERM HUP
  if [ "$status" -ne 0 ]; then
    last="$(tail -n 25 "$log")"
    printf ' failed\n%s\n' "$last" >&2
    fail "$title" "exit status $status of '$*' (whole output: $log)" "$remedy"
  fi
  [ -t 1 ] && printf '\r'
  [ -t 1 ] && printf '%s ... done in %d s\n' "$title" $((SECONDS - started)) ||
    printf ' done in %d s\n' $((SECONDS - started))
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    echo "neither root nor sudo: cannot run '$*'" >&2
    return 1
  fi
}

packages_of() { sed 's/#.*//' "$@" | tr -s ' \t\n' '\n' | sed '/^$/d' | sort -u; }

missing_packages() {
  local wanted="$1" installed
  # shellcheck disable=SC2086
  installed="$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' $wanted 2>/dev/null | awk '$1 ~ /^.i$/ {print $2}' | sort -u)"
  comm -23 <(printf '%s\n' $wanted) <(printf '%s\n' "$installed")
}

install_system_packages() {
  local lists=("$root/launch_scripts/packages/$platform.txt") wanted missing
  [ -n "$with_tests" ] && lists+=("$root/launch_scripts/packages/$platform-test.txt")
  wanted="$(packages_of "${lists[@]}")"
  # A Node.js from elsewhere brings an npm of its own, and does not go together with Debian's.
  [ -z "$with_tests" ] || command -v npm >/dev/null || wanted="$(printf '%s\nnpm\n' "$wanted" | sort)"
  missing="$(missing_packages "$wanted")"
  [ -z "$missing" ] && return 0
  local remedy="check the network and the package sources (apt-get update), or install by hand: apt-get install --no-install-recommends $(echo $missing)"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      fail "System packages" "not root, and there is no sudo" "as root: apt-get install --no-install-recommends $(echo $missing)"
    sudo -n true 2>/dev/null || sudo -v || fail "System packages" "sudo refused" "as root: apt-get install --no-install-recommends $(echo $missing)"
  fi
  finishes=1
  step "Package lists" "$remedy" as_root apt-get update -q
  step "System packages ($(echo "$missing" | wc -l) missing)" "$remedy" \
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
  finishes=
}

make_venv() {
  local requirements=("$root/requirements.txt") stamp="$root/.venv/.telex-requirements" wanted pip_arguments=()
  local tests=("$root/requirements-test.txt" "$root/requirements-many-machines.txt" "$root/requirements-research.txt")
  [ -n "$with_tests" ] && requirements+=("${tests[@]}")
  wanted="$("$python" --version) $root $(cat "${requirements[@]}" | sha256sum)"
  # An environment that has the tests' packages too serves run.sh as well.
  local both
  both="$("$python" --version) $root $(cat "$root/requirements.txt" "${tests[@]}" | sha256sum)"
  if [ -x "$root/.venv/bin/python" ] && [ -f "$stamp" ]; then
    case "$(cat "$stamp")" in "$wanted" | "$both") return 0 ;; esac
  fi
  local remedy="delete $root/.venv, check that PyPI (or your pip index) can be reached, and start again"
  # A moved checkout or another Python makes an environment useless; --clear starts it anew.
  case "$(cat "$stamp" 2>/dev/null)" in
    "$("$python" --version) $root "*) ;;
    *) step "Python environment" "$remedy" "$python" -m venv --clear --system-site-packages "$root/.venv" ;;
  esac
  local list
  for list in "${requirements[@]}"; do pip_arguments+=(-r "$list"); done
  rm -f "$stamp"
  step "Python packages" "$remedy" \
    "$root/.venv/bin/python" -m pip install --disable-pip-version-check "${pip_arguments[@]}"
  printf '%s' "$wanted" >"$stamp"
}

# What the build reads. Python sources are used where they stand and need no build.
build_inputs() {
  cd "$root"
  { find src -type f \( -name CMakeLists.txt -o -name package.xml -o -name setup.py -o -name '*.msg' \
      -o -name '*.srv' -o -name '*.action' -o -name '*.cfg' \) -not -path src/CMakeLists.txt -not -path '*/node_modules/*' -print0 | sort -z | xargs -0 sha256sum
    find src -path '*/src/*' -type d -not -name __pycache__ -not -path '*/node_modules/*' -print | sort
    echo "$root $("$python" --version)"
  } | sha256sum
}

build_workspace() {
  local stamp="$state/build" wanted
  wanted="$(build_inputs)"
  [ -f "$root/devel/setup.bash" ] && [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ] && return 0
  rm -f "$stamp"
  # CMake remembers absolute paths: a moved checkout is built anew.
  if [ -f "$root/build/CMakeCache.txt" ] && ! grep -qF "CMAKE_HOME_DIRECTORY:INTERNAL=$root/src" "$root/build/CMakeCache.txt"; then
    rm -rf "$root/build" "$root/devel"
  fi
  # catkin_make believes PWD, which env -C leaves as it was.
  step "Workspace (catkin_make)" "read the messages above; 'rm -rf build devel' starts the build anew" \
    env -C "$root" PWD="$root" PATH="$root/.venv/bin:$PATH" catkin_make -DPYTHON_EXECUTABLE="$root/.venv/bin/python" -DCATKIN_ENABLE_TESTING=OFF
  printf '%s' "$wanted" >"$stamp"
}

# numba compiles inverse kinematics once for a machine and keeps it beside the source: 15 s that no
# node is to spend when it starts.
compile_kinematics() {
  local stamp="$state/kinematics" wanted kernels="$root/src/telex_control/src/telex_control/kinematics/inverse"
  wanted="$(cat "$root/requirements.txt" "$kernels"/*.py | sha256sum)"
  [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ] && [ -n "$(ls "$kernels"/__pycache__/*.nbi 2>/dev/null)" ] && return 0
  rm -f "$stamp"
  step "Inverse kinematics (numba)" "read the messages above; without it, nodes compile at their first start" \
    env PYTHONPATH="$root/src/telex_control/src:${PYTHONPATH-}" "$root/.venv/bin/python" -m telex_control.kinematics.inverse.compile
  printf '%s' "$wanted" >"$stamp"
}

# Textures, meshes and shaders of the shipped scenes, which are kept in the user's cache folder: seconds
# that the cameras are not to spend when a scene is wanted. What changes later is made when it is shown.
prepare_scenes() {
  local stamp="$state/scenes" cache="${XDG_CACHE_HOME:-${HOME-}/.cache}" sources=(
    "$root"/src/telex_sim/{src/telex_sim/cameras,src/telex_sim/scene,scenes} "$root"/src/telex_description/{config,meshes,urdf})
  [ "$(cat "$stamp" 2>/dev/null)" = "$cache" ] && [ -d "$cache/telex_sim/content" ] &&
    [ -z "$(find "${sources[@]}" -type f -newer "$stamp" -not -name '*.pyc' -print -quit)" ] && return 0
  mkdir -p "$cache/telex_sim/content" 2>/dev/null && [ -w "$cache/telex_sim/content" ] || return 0
  rm -f "$stamp"
  # Where it fails, they are prepared whenever they are shown: no reason to end here, nor to try it at every start.
  (step "Pictures of the scenes" "the simulator starts without them" \
    bash -c '. "$1/env.sh" && exec python -m telex_sim.cameras.preview.prepare' bash "$root") || [ $? -ne 130 ] || exit 130
  printf '%s' "$cache" >"$stamp"
}

# npm_packages TITLE FOLDER: what the package-lock.json of a folder names.
npm_packages() {
  local folder="$root/$2" stamp wanted
  stamp="$state/npm_$(basename "$folder")"
  wanted="$(cat "$folder/package-lock.json" | sha256sum)"
  [ "$(cat "$stamp" 2>/dev/null)" = "$wanted" ] && [ -d "$folder/node_modules" ] && return 0
  rm -f "$stamp"
  if ! (step "$1 (npm)" "the tests go on without it" env -C "$folder" npm ci --no-audit --no-fund); then
    rm -rf "$folder/node_modules"
    return 0
  fi
  printf '%s' "$wanted" >"$stamp"
}

# What only tests take from npm. Where roslib cannot be had, its tests are skipped; without TypeScript
# test.sh says that the page's types were not checked.
install_npm_packages() {
  command -v npm >/dev/null || return 0
  npm_packages roslib src/telex_teleop/test/bridge_clients
  npm_packages TypeScript src/telex_teleop/test/javascript
}

command -v flock >/dev/null && command -v dpkg-query >/dev/null ||
  fail "Set-up" "this is no Debian or Ubuntu system" "use Debian 12, or Ubuntu 20.04 with ROS Noetic"
if [ -f /opt/ros/noetic/setup.bash ]; then
  platform=ubuntu2004
  set +u
  # shellcheck disable=SC1091
  . /opt/ros/noetic/setup.bash
  set -u
else
  platform=debian12
  # shellcheck disable=SC1091
  system="$(. /etc/os-release && echo "${ID:-} ${VERSION_ID:-}")"
  [ "$system" = "debian 12" ] ||
    echo "setup.sh: this is '$system'; only Debian 12 is tested, its package names are tried" >&2
fi
# ROS belongs to the system's Python; another one first on PATH lacks it.
python=/usr/bin/python3
: >"$log"
install_system_packages
make_venv
build_workspace
compile_kinematics
prepare_scenes
[ -z "$with_tests" ] || install_npm_packages
