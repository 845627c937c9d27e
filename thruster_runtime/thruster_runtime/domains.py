"""A ROS domain that no other graph of this machine is in, for tests and scripts that start graphs side by side.

python3 -m thruster_runtime.domains     # prints one that is free now; a shell script's graph takes it at once
"""

import fcntl
import random
import socket
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import IO

__all__ = ["is_quiet", "reserved_domain"]

_DOMAINS = range(1, 102)
"""Those that all systems allow: their ports lie below the ephemeral ones."""
_held: list[IO[bytes]] = []


def is_quiet(domain: int) -> bool:
    """Tell whether the first participant's port of a domain is free on this machine (DDSI-RTPS, 9.6.1.1)."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", 7410 + 250 * domain))
        except OSError:
            return False
    return True


def reserved_domain(among: Iterable[int] | None = None) -> int:
    """Return a domain that is quiet, and that no other process gets from here while this one lives.

    Raises:
        RuntimeError: none is left.
    """
    for domain in random.sample(_DOMAINS, len(_DOMAINS)) if among is None else among:
        try:
            # The lock goes with the process, however that ends; a file of another user counts as taken.
            file = (Path(tempfile.gettempdir()) / f"ros_domain_{domain}.lock").open("ab")
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            continue
        if is_quiet(domain):
            _held.append(file)
            return domain
        file.close()
    raise RuntimeError("expected a ROS domain that no graph of this machine is in; found none of 1 to 101")


if __name__ == "__main__":
    sys.stdout.write(f"{reserved_domain()}\n")
