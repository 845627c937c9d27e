"""The message of /tf, where it is built here: the same type as everywhere."""

from pathlib import Path

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from run_bag.definitions import definitions

NAME = "tf2_msgs/msg/TFMessage"
TEXT = (Path(__file__).parents[1] / "scripts/stand_in/tf2_msgs/msg/TFMessage.msg").read_text(encoding="utf-8")


def test_the_definition_built_here_has_the_type_hash_of_jazzys() -> None:
    jazzy, ours = get_typestore(Stores.ROS2_JAZZY), get_typestore(Stores.ROS2_JAZZY)
    ours.types.pop(NAME, None)
    ours.fielddefs.pop(NAME)
    ours.register(get_types_from_msg(TEXT, NAME))
    assert ours.hash_rihs01(NAME) == jazzy.hash_rihs01(NAME) == definitions().type_hash(NAME)


def test_a_transform_published_here_is_read_by_the_definition_that_recordings_carry() -> None:
    from geometry_msgs.msg import TransformStamped
    from rclpy.serialization import serialize_message
    from tf2_msgs.msg import TFMessage

    one = TransformStamped(child_frame_id="base_link")
    one.transform.translation.z = -2.5
    read = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(serialize_message(TFMessage(transforms=[one])), NAME)
    assert [(t.child_frame_id, t.transform.translation.z) for t in read.transforms] == [("base_link", -2.5)]  # type: ignore[attr-defined]
