from itertools import permutations

import pytest

from thruster_runtime.triggered_join import Due, Input, TriggeredJoin, held, newest_within

FLOW, THROTTLE = Input(timeout=100), Input(timeout=100, former=True)


def joined(**inputs: Input) -> TriggeredJoin:
    return TriggeredJoin("state", inputs or {"flow": FLOW, "throttle": THROTTLE})


@pytest.mark.parametrize("order", list(permutations(["state", "flow", "throttle"])))
def test_a_trigger_waits_for_the_input_of_its_stamp_and_for_the_one_that_acted_before(order: tuple[str, ...]) -> None:
    join = joined()
    join.put("state", 40, "s40")
    (first,) = join.put("flow", 40, "f40")
    assert first == Due(40, None, "s40", {"flow": ((40, "f40"),), "throttle": ()}, ())
    sent = {"state": 80, "flow": 80, "throttle": 40}
    due = [join.put(name, sent[name], f"{name[0]}{sent[name]}") for name in order]
    assert due[:2] == [(), ()]
    assert due[2] == (Due(80, 40, "s80", {"flow": ((40, "f40"), (80, "f80")), "throttle": ((40, "t40"),)}, ()),)
    assert not any(join.missing.values()) and not any(join.late.values())


def test_no_trigger_waits_longer_than_until_the_next_and_what_it_lacked_is_counted() -> None:
    join = joined(flow=FLOW)
    join.put("flow", 40, "f40")
    join.put("state", 40, "")
    assert join.put("state", 80, "s80") == ()
    assert join.waiting == ("flow",)
    (due,) = join.put("state", 120, "s120")
    assert (due.stamp, due.lacking, due.inputs["flow"]) == (80, ("flow",), ((40, "f40"),))
    assert join.put("flow", 80, "f80") == ()
    assert (join.missing["flow"], join.late["flow"]) == (1, 1)
    (due,) = join.put("flow", 120, "f120")
    assert due.inputs["flow"] == ((80, "f80"), (120, "f120"))


def test_an_input_that_is_silent_for_longer_than_its_time_out_is_not_waited_for_until_it_comes_again() -> None:
    join = joined(flow=FLOW)
    assert join.put("state", 0, "") == ()
    released = [len(join.put("state", stamp, "")) for stamp in (40, 80, 120, 160)]
    assert released == [1, 1, 2, 1], "at 120 the former trigger and this one"
    assert join.missing["flow"] == 3
    join.put("flow", 160, "")
    assert join.put("state", 200, "") == ()
    assert len(join.put("flow", 200, "")) == 1


def test_an_input_that_is_not_waited_for_gives_the_newest_up_to_the_trigger() -> None:
    join = joined(flow=Input(timeout=100, wait=False))
    for stamp in (10, 30, 50):
        join.put("flow", stamp, f"f{stamp}")
    (due,) = join.put("state", 40, "")
    assert due.inputs["flow"][-1] == (30, "f30")
    (due,) = join.put("state", 80, "")
    assert due.inputs["flow"] == ((30, "f30"), (50, "f50"))
    assert join.missing["flow"] == 0


def test_memory_is_bounded() -> None:
    join = TriggeredJoin("state", {"flow": FLOW}, depth=4)
    for stamp in range(100):
        join.put("flow", stamp, stamp)
    (due,) = join.put("state", 99, "")
    assert [stamp for stamp, _ in due.inputs["flow"]] == [96, 97, 98, 99]


def test_a_trigger_that_starts_again_forgets_what_is_stamped_later_and_not_what_came_for_it() -> None:
    join = joined(flow=FLOW)
    for stamp in (1000, 1040):
        join.put("state", stamp, "")
        join.put("flow", stamp, f"f{stamp}")
    assert join.put("flow", 0, "f0") == ()
    (due,) = join.put("state", 0, "s0")
    assert (due.former, due.inputs["flow"], join.restarts) == (None, ((0, "f0"),), 1)


def test_a_trigger_that_starts_again_is_not_content_with_inputs_of_the_time_before() -> None:
    join = joined(flow=FLOW)
    join.put("flow", 1000, "")
    assert len(join.put("state", 1000, "")) == 1
    assert join.put("state", 0, "") == ()
    (due,) = join.put("flow", 0, "f0")
    assert due.inputs["flow"] == ((0, "f0"),)


def test_a_repeated_trigger_is_counted_and_not_answered_again() -> None:
    join = joined(flow=Input(timeout=100, wait=False))
    assert len(join.put("state", 40, "")) == 1
    assert join.put("state", 40, "") == ()
    assert join.late["state"] == 1


def test_a_measurement_counts_once_and_a_command_is_held_until_it_is_too_old() -> None:
    due = Due(80, 40, "", {"x": ((40, "old"),)}, ())
    assert newest_within(due, "x") is None
    assert newest_within(due._replace(former=39), "x") == "old"
    assert newest_within(due._replace(former=None), "x") == "old"
    assert (held(due, "x", 40), held(due, "x", 39)) == ("old", None)
    assert held(due._replace(inputs={"x": ()}), "x", 40) is None


def test_a_trigger_that_is_an_input_and_a_name_that_is_neither_are_refused() -> None:
    with pytest.raises(ValueError, match="expected a trigger of its own"):
        TriggeredJoin("state", {"state": FLOW})
    with pytest.raises(KeyError, match="expected one of state, flow, throttle; found 'load'"):
        joined().put("load", 0, "")


def test_of_a_slower_input_the_newest_that_is_due_is_waited_for() -> None:
    join = joined(depth=Input(timeout=1000, every=100))
    assert [len(join.put("state", stamp, "")) for stamp in (25, 50, 75)] == [1, 1, 1], "none is due yet"
    assert join.put("state", 100, "") == ()
    (due,) = join.put("depth", 100, "d100")
    assert due.inputs["depth"] == ((100, "d100"),)
    assert [len(join.put("state", stamp, "")) for stamp in (125, 150, 175)] == [1, 1, 1]
    assert join.put("state", 200, "") == ()
    assert len(join.put("depth", 200, "d200")) == 1
    assert join.missing["depth"] == 0


def test_a_slower_input_that_comes_late_by_its_delay_holds_nothing_up() -> None:
    join = joined(depth=Input(timeout=1000, every=130))
    released = [len(join.put("state", stamp, "")) for stamp in (25, 50, 75, 100, 125)]
    assert released == [1, 1, 1, 1, 1]
    join.put("depth", 100, "d100")
    assert [len(join.put("state", stamp, "")) for stamp in (150, 175, 200, 225)] == [1, 1, 1, 1]
    assert join.put("state", 250, "") == (), "what was measured at 200 is due at 230"
    (due,) = join.put("depth", 200, "d200")
    assert due.inputs["depth"][-1] == (200, "d200")


def test_the_first_of_a_slower_input_is_waited_for_from_when_it_is_due() -> None:
    join = joined(depth=Input(timeout=1000, every=100, first=130))
    assert [len(join.put("state", stamp, "")) for stamp in (25, 50, 75, 100, 125)] == [1] * 5
    assert join.put("state", 150, "") == ()
    assert len(join.put("depth", 130, "d130")) == 1
