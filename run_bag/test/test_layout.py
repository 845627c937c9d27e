"""Our bytes against those of rosbags' own serialiser, message type by message type."""

import numpy as np
import pytest
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from run_bag import SchemaError
from run_bag.decode import decode
from run_bag.definitions import definitions, message_folders, parse_schema
from run_bag.topic import Topic, check_topic
from run_bag.units import UNITS, unit_of

KINDS = sorted(
    {f"thruster_msgs/msg/{p.stem}" for f in message_folders("thruster_msgs") for p in f.glob("*.msg")}
    | set(UNITS) - {"diagnostic_msgs/msg/DiagnosticArray"}
    | {"std_msgs/msg/Float64", "std_msgs/msg/String", "std_msgs/msg/Empty", "sensor_msgs/msg/JointState",
       "std_msgs/msg/Bool", "geometry_msgs/msg/PolygonStamped", "sensor_msgs/msg/Range"}
)  # fmt: skip


def fill(store, name, random, path, columns):
    """Make a random message of rosbags' own classes and note the columns that describe it."""
    values = []
    for field, (kind, detail) in store.fielddefs[name][1]:
        where = f"{path}.{field}" if path else field
        if kind == Nodetype.NAME:
            values.append(fill(store, detail, random, where, columns))
        elif kind == Nodetype.BASE:
            values.append(scalar(detail[0], random))
            columns[where] = values[-1]
        else:
            element, count = detail
            count = count if kind == Nodetype.ARRAY else 3
            if element[0] == Nodetype.NAME or element[1][0] == "string":
                values.append([])  # sequences of messages or strings: empty
                continue
            dtype = {"bool": "bool", "char": "uint8", "byte": "uint8"}.get(element[1][0], element[1][0])
            values.append(np.array([scalar(element[1][0], random) for _ in range(count)], dtype=dtype))
            columns[where] = values[-1]
    return store.types[name](*values)


def scalar(kind, random):
    if kind == "string":
        return "".join(random.choice(list("abcé"), size=random.integers(0, 9)))
    if kind.startswith("float"):
        return float(np.dtype(kind).type(random.normal()))
    if kind == "bool":
        return bool(random.integers(2))
    info = np.iinfo({"char": "uint8", "byte": "uint8"}.get(kind, kind))
    return int(random.integers(max(info.min, -(2**31)), min(info.max, 2**31 - 1)))


@pytest.mark.parametrize("kind", KINDS)
def test_messages_are_byte_for_byte_those_of_rosbags_and_decode_to_what_went_in(kind):
    known = definitions()
    known.require(kind)
    random = np.random.default_rng(3)
    for _ in range(5):
        columns = {}
        message = fill(known.store, kind, random, "", columns)
        frame = columns.pop("header.frame_id", "")
        sec, nanosec = columns.pop("header.stamp.sec", 0), columns.pop("header.stamp.nanosec", 0)
        if hasattr(message, "header"):
            sec, nanosec = abs(sec), nanosec % 10**9
            message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
        fields = {k: v if isinstance(v, str) else np.array([v]) for k, v in columns.items()}
        topic = Topic(name="t", type=kind, stamps=[sec * 10**9 + nanosec], fields=fields, frame=frame)
        (ours,) = check_topic(topic).payloads(0, 1)
        theirs = bytes(known.store.serialize_cdr(message, kind, little_endian=True))
        assert ours == theirs
        for raw in (ours, bytes(known.store.serialize_cdr(message, kind, little_endian=False))):
            back = decode(known.fields(kind), kind, [raw])
            for path, value in columns.items():
                if isinstance(value, np.ndarray):
                    assert [back.values[f"{path}[{i}]"][0] for i in range(len(value))] == value.tolist()
                elif not isinstance(value, str) and path != "structure_needs_at_least_one_member":
                    assert back.values[path][0] == value
            if hasattr(message, "header"):
                assert back.header_stamps.tolist() == [sec * 10**9 + nanosec] and back.frames == {frame}


def test_messages_of_changing_lengths_are_decoded_each_by_its_own_layout():
    store = get_typestore(Stores.ROS2_JAZZY)
    kind = "sensor_msgs/msg/JointState"
    head = store.types["std_msgs/msg/Header"](store.types["builtin_interfaces/msg/Time"](1, 2), "f")
    raws, empty = [], np.array([])
    for i in range(100):
        position = np.arange(i % 3, dtype=float) + i
        message = store.types[kind](head, ["n" * (i % 41)], position, empty, empty)
        raws.append(bytes(store.serialize_cdr(message, kind)))
    back = decode({k: v[1] for k, v in store.fielddefs.items()}, kind, raws)
    first = [float(i) if i % 3 else np.nan for i in range(100)]
    np.testing.assert_equal(back.values["position[0]"], first)
    assert set(back.values) == {"position[0]", "position[1]"}


@pytest.mark.parametrize("kind", [k for k in KINDS if k.startswith("thruster_msgs")])
def test_the_stored_definition_is_complete_and_has_the_type_hash_of_the_installed_one(kind):
    text = definitions().text(kind)
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, kind))
    assert store.hash_rihs01(kind) == definitions().type_hash(kind)
    assert parse_schema(kind, "ros2msg", text.encode())[kind] == definitions().fields(kind)[kind]


@pytest.mark.parametrize("kind", [k for k in KINDS if k in UNITS])
def test_every_number_of_a_known_message_has_a_unit(kind):
    columns = {}
    known = definitions()
    known.require(kind)
    fill(known.store, kind, np.random.default_rng(0), "", columns)
    for path, value in columns.items():
        if not path.startswith("header.") and not isinstance(value, str):
            indexed = f"{path}[0]" if isinstance(value, np.ndarray) else path
            assert unit_of(kind, indexed), f"{kind} {path} has no unit"


def test_the_published_hash_of_a_wrench_is_that_of_jazzy():
    expected = "RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"
    assert definitions().type_hash("geometry_msgs/msg/WrenchStamped") == expected


def test_garbage_is_refused_with_the_index_of_the_message():
    kind = "std_msgs/msg/Float64"
    fields = definitions().fields(kind)
    good = b"\0\1\0\0" + bytes(8)
    for bad, sentence in [(b"\0\7\0\0" + bytes(8), "plain CDR"), (good[:-1], "expected 12 bytes")]:
        with pytest.raises(SchemaError, match=f"message 1: .*{sentence}") as caught:
            decode(fields, kind, [good, bad])
        assert caught.value.position == 1
