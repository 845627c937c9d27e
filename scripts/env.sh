# Bring ROS 2, the virtual environment and the packages into this shell:   . scripts/env.sh
# For bash. Works from any folder, under `set -eu`, and more than once.

_workspace=$(cd "$(dirname "${BASH_SOURCE[0]:?scripts/env.sh is for bash}")/.." && pwd -P)
if [ ! -e "$_workspace/install/.setup_complete" ]; then
    printf 'The workspace is not ready: run %s/scripts/setup.sh first.\n' "$_workspace" >&2
    unset _workspace
    return 1
fi
. "$_workspace/scripts/workspace/underlay.sh"

# The ROS installation that setup.sh found and built on, not the one that this shell would find now.
_ros=$(sed -n '1s/^.* on //p' "$_workspace/install/.setup_complete")
if [ "$_ros" = PyPI ]; then _ros=$_workspace/.venv; fi
case ":${AMENT_PREFIX_PATH-}:" in
*":$_ros:"*) ;;
*) source_foreign "$_ros/setup.bash" ;;
esac
export VIRTUAL_ENV=$_workspace/.venv
case "$PATH" in
"$VIRTUAL_ENV/bin:"*) ;;
*) PATH=$VIRTUAL_ENV/bin:$PATH ;;
esac
source_foreign "$_workspace/install/local_setup.bash"
if ! command -v ros2 >/dev/null; then PATH=$PATH:$_workspace/scripts/stand_in; fi
export PATH
# Discovery in 0.4 s instead of 2.6 s, and no one else on the network is spoken to; a vehicle's network sets its own.
export ROS_AUTOMATIC_DISCOVERY_RANGE=${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}
unset _workspace _ros
