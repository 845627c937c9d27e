"""Domains for graphs side by side."""

import os
import socket
import subprocess
import sys

import pytest

from thruster_runtime.domains import is_quiet, reserved_domain


def test_a_domain_is_given_once_until_its_process_has_ended():
    hold = "from thruster_runtime.domains import reserved_domain; print(reserved_domain(), flush=True); input()"
    first = reserved_domain()
    with subprocess.Popen(
        [sys.executable, "-c", hold], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        theirs = int(other.stdout.readline())
        assert theirs not in (first, int(os.environ["ROS_DOMAIN_ID"]))
        with pytest.raises(RuntimeError, match="no graph of this machine is in; found none"):
            reserved_domain([theirs])
        other.communicate("\n")
    assert reserved_domain([theirs]) == theirs


def test_a_domain_with_a_participant_is_not_quiet():
    domain = reserved_domain()
    assert is_quiet(domain)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as participant:
        participant.bind(("", 7410 + 250 * domain))
        assert not is_quiet(domain)
