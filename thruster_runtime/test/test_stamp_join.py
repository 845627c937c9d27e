import pytest
from builtin_interfaces.msg import Time
from hypothesis import given, settings
from hypothesis import strategies as st

from thruster_runtime.stamp_join import StampJoin, nanoseconds


def test_a_stamp_is_integer_nanoseconds() -> None:
    # As a float, 2 ** 31 s + 1 ns would lose the nanosecond.
    assert nanoseconds(Time(sec=2**31 - 1, nanosec=1)) == (2**31 - 1) * 10**9 + 1


def test_messages_of_one_stamp_come_out_together_when_the_last_has_come() -> None:
    join = StampJoin(["a", "b", "c"])
    assert join.put("b", 40, "b40") is None
    assert join.put("a", 40, "a40") is None
    assert join.waiting == {40: ("c",)}
    assert join.put("c", 40, "c40") == {"a": "a40", "b": "b40", "c": "c40"}
    assert (join.waiting, join.done) == ({}, 40)


@settings(max_examples=50, deadline=None)
@given(st.permutations(range(9)))
def test_whatever_the_order_across_names_every_stamp_comes_out_once_and_in_order(order: list[int]) -> None:
    names = ("a", "b", "c")
    turns = [names[i % 3] for i in order]
    sent, out = dict.fromkeys(names, 0), []
    join = StampJoin(names)
    for name in turns:
        sent[name] += 40
        if (found := join.put(name, sent[name], sent[name])) is not None:
            out.append(found)
    assert out == [dict.fromkeys(names, stamp) for stamp in (40, 80, 120)]
    assert not any(join.missing.values()) and not any(join.late.values())


def test_what_never_came_is_counted_when_a_later_stamp_is_complete_and_what_comes_then_is_late() -> None:
    join = StampJoin(["a", "b"])
    join.put("a", 40, "")
    join.put("a", 80, "")
    assert join.put("b", 80, "") is not None
    assert (join.missing, join.late) == ({"a": 0, "b": 1}, {"a": 0, "b": 0})
    assert join.put("b", 80, "") is None
    assert join.late == {"a": 0, "b": 1}


def test_memory_is_bounded_by_giving_up_the_oldest() -> None:
    join = StampJoin(["a", "b"], depth=3)
    for stamp in range(10):
        assert join.put("a", stamp, "") is None
    assert tuple(join.waiting) == (7, 8, 9)
    assert join.missing == {"a": 0, "b": 7}
    assert join.put("b", 6, "") is None
    assert join.late["b"] == 1
    assert join.put("b", 7, "") == {"a": "", "b": ""}


def test_a_second_message_of_a_waiting_stamp_takes_the_place_of_the_first() -> None:
    join = StampJoin(["a", "b"])
    join.put("a", 40, "first")
    join.put("a", 40, "second")
    assert join.put("b", 40, "") == {"a": "second", "b": ""}


def test_taking_a_stamp_early_gives_what_has_come_and_ends_the_wait() -> None:
    join = StampJoin(["a", "b"])
    join.put("a", 40, "a40")
    assert join.take(40) == {"a": "a40"}
    assert join.missing == {"a": 0, "b": 1}
    assert join.take(80) == {}
    assert join.put("a", 60, "") is None
    assert join.late == {"a": 1, "b": 0}


def test_a_source_that_starts_again_begins_a_new_join() -> None:
    join = StampJoin(["a", "b"])
    for stamp in (40, 80):
        join.put("a", stamp, "")
        join.put("b", stamp, "")
    assert join.put("b", 0, "") is None
    assert join.put("a", 0, "") is not None
    assert (join.restarts, join.done, sum(join.late.values())) == (1, 0, 0)


@pytest.mark.parametrize("wrong", [([], 10), (["a", "a"], 10), (["a"], 0)])
def test_a_join_of_nothing_is_refused(wrong: tuple[list[str], int]) -> None:
    with pytest.raises(ValueError, match="expected different names and a depth of 1 or more"):
        StampJoin(wrong[0], depth=wrong[1])


def test_a_name_that_is_not_joined_is_refused() -> None:
    with pytest.raises(KeyError, match="expected one of a; found 'b'"):
        StampJoin(["a"]).put("b", 0, "")
