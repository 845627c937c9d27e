# Bring ROS 2, the virtual environment and the packages into this shell:   . scripts/env.sh
# For bash and zsh. Works from any folder, under `set -eu`, and more than once.
#
# THRUSTER_NETWORK decides who takes part in graphs: machine (this machine alone, also where it is not set) or network.

if [ -n "${BASH_VERSION-}" ]; then
    _shell=bash _file=${BASH_SOURCE[0]}
elif [ -n "${ZSH_VERSION-}" ]; then
    _shell=zsh
    eval '_file=${(%):-%x}' # which other shells cannot read
else
    printf 'scripts/env.sh is for bash and zsh: run one of them, and source it there.\n' >&2
    return 1
fi
_workspace=$(cd "$(dirname "$_file")/.." && pwd -P)
if [ ! -e "$_workspace/install/.setup_complete" ]; then
    printf 'The workspace is not ready: run %s/scripts/setup.sh first.\n' "$_workspace" >&2
    unset _workspace _shell _file
    return 1
fi
. "$_workspace/scripts/workspace/underlay.sh"

# The ROS installation that setup.sh found and built on, not the one that this shell would find now.
_ros=$(sed -n '1s/^.* on //p' "$_workspace/install/.setup_complete")
if [ "$_ros" = PyPI ]; then _ros=$_workspace/.venv; fi
case ":${AMENT_PREFIX_PATH-}:" in
*":$_ros:"*) ;;
*) source_foreign "$_ros/setup.$_shell" ;;
esac
export VIRTUAL_ENV=$_workspace/.venv
case "$PATH" in
"$VIRTUAL_ENV/bin:"*) ;;
*) PATH=$VIRTUAL_ENV/bin:$PATH ;;
esac
source_foreign "$_workspace/install/local_setup.$_shell"
if ! command -v ros2 >/dev/null; then PATH=$PATH:$_workspace/scripts/stand_in; fi
export PATH
unset _workspace _ros _shell _file
discovery || return
