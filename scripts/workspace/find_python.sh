# Sourced by setup.sh: which Python the virtual environment is made with.

# Runs in a candidate; prints its version, or one reason against it. A candidate that does not run at all prints nothing,
# which is what a version manager's wrapper for a version that is not active does.
python_check='
import importlib.util, os, sys, sysconfig
version = "%d.%d" % sys.version_info[:2]
if not (3, 10) <= sys.version_info[:2] <= (3, 13):
    print("no", sys.executable, "is Python", version)
elif importlib.util.find_spec("venv") is None or importlib.util.find_spec("ensurepip") is None:
    print("no", sys.executable, "lacks the module venv (Debian, Ubuntu: apt install python%s-venv)" % version)
elif not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")):
    print("no", sys.executable, "lacks its C headers (Debian, Ubuntu: apt install python%s-dev)" % version)
elif len(sys.argv) > 1 and importlib.util.find_spec(sys.argv[1]) is None:
    print("no", sys.executable, "cannot import", sys.argv[1])
else:
    print("yes", sys.executable)
'

find_python() { # [MODULE]: set `python` to the first usable Python (that has MODULE), or `python_trouble` to why there is none
    local candidate answer
    python='' python_trouble=''
    for candidate in ${PYTHON:-python3.12 python3 python3.13 python3.11 python3.10}; do
        answer=$("$candidate" -c "$python_check" "$@" 2>/dev/null) || continue
        case $answer in
        yes*)
            python=${answer#yes }
            return
            ;;
        # The first Python of the right version that only lacks a part is the one worth mending.
        *lacks* | *cannot*) python_trouble=${python_trouble:-${answer#no }} ;;
        esac
    done
    python_trouble=${python_trouble:-"install Python 3.10, 3.11, 3.12 or 3.13 with its venv module and headers${PYTHON:+ (PYTHON=$PYTHON is none)} (Debian, Ubuntu: apt install python3 python3-venv python3-dev)"}
}
