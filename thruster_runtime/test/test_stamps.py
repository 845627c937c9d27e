from builtin_interfaces.msg import Time

from thruster_runtime.stamps import nanoseconds


def test_a_stamp_is_integer_nanoseconds() -> None:
    # As a float, 2 ** 31 s + 1 ns would lose the nanosecond.
    assert nanoseconds(Time(sec=2**31 - 1, nanosec=1)) == (2**31 - 1) * 10**9 + 1
