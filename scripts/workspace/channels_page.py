"""Print docs/channels.md: channels that a map can name, and units that it takes, from the tables of the code."""

import re
import sys
from collections.abc import Sequence

from run_bag.importers.axes import unit_in_map
from run_bag.importers.conversions import COMMANDS, CONVERSIONS, PASCALS
from run_bag.known_topics import topic_type
from run_bag.topics_table import KnownChannel, channels, topics, units

HEAD = """\
# Channels and units of a map

Made by `scripts/workspace/channels_page.py` from the tables of the code. How a map is written:
[any_recording.md](any_recording.md). `<i>` is a thruster's number, from 0. Any [other field](#other-fields)
can be named, too, such as set points, gauges and estimates: `show` draws it, and no fit or diagnosis reads it.
A controller has no place in a map; what counts is what it sends.

## Channels
"""
UNITS = """
## Units
A column may be in any of these; the import brings it to the channel's own unit.

"""
FOOT = f"""
- A throttle, in V, may also be in {", ".join(f"`{unit}`" for unit in COMMANDS)}, with both `stop`
  and `per_volt`. `'1'` is −1 to 1, `counts` any numbers of a device.
- Full command is 5 V: `per_volt` is 80 for 1100 to 1900 µs, 20 for −100 to 100 %, 10 for 0 to 100 % with
  `stop: 50`, 0.2 for −1 to 1. Of a converter of 12 bits with rest at 2048 and full command 2000 counts from it,
  it is 400, `stop` 2048.
- Which model reads which flow: [models.md](models.md).
- `Hz`, `1/s`, `rps` and `rev/s` are turns per second. `g` and `kg` of a force are `gf` and `kgf`.
- A depth may also be in {", ".join(f"`{unit}`" for unit in PASCALS)}: pressure over that at the surface, as that
  of fresh water. 1 dbar is 1.01972 m of it. Of salt water, or of an absolute pressure, write `scale` and `offset`.
- Counts are `Digit`, `LSB`, `raw` or `ADC`, too. Letters may be small or capital where no other unit differs by them
  alone: `mG` is `mg`.
- Usual spellings are taken: `µs`, `°C`, `N·m`, `U/min`, `sec`, and `m/s²`, `m/s2`, `m/s^2`, `m s^-2` or `m/s/s` alike.
  YAML wants quotes about `'%'` and `'U1 [V]'`.
"""

COLUMNS = {
    "throttle.commanded": "command, cmd, throttle, pwm, esc, u, duty, stick, dac, setpoint, U_soll, Sollwert, "
    "Stellgroesse",
    "state.n": "n, rpm, speed, motor_rpm, tacho, rotor, shaft, encoder, enc, revs, Drehzahl, Drehgeber",
    "state.supply_voltage": "supply, battery, vdc, Akku, Versorgungsspannung",
    "state.current": "current, amps, i, Strom",
    "load.wrench.force.x": "thrust, force, load_cell, pull, Fx, Schub, Kraft, Kraftmessdose",
    "load.wrench.torque.x": "torque, moment, Mx, q, Drehmoment",
    "flow.ambient": "flow, ambient, water_speed, inflow, stream, adv, tank, outside, v_aussen, Strömung",
    "flow.axial": "axial, duct, axial_flow, inside, v_innen, v_Duese",
}
"""Words that a proposal knows in columns of a thruster."""
TOPICS = {
    "throttle.commanded": ("JointState", "effort", "cmd, command, throttle, setpoint, soll, stellwert"),
    "state.n": ("JointState", "velocity", "thruster, motor, rotor, esc, rpm, thr, encoder, drive, shaft, tacho"),
    "load.wrench.force.x": ("WrenchStamped", "wrench.force.x", "load, cell, force, wrench, thrust, ft"),
    "flow.axial": ("TwistStamped", "twist.linear.x", "axial, duct, inside"),
    "flow.ambient": (
        "TwistStamped", "twist.linear.x",
        "ambient, outside, tank, tunnel, adv, flow, water, current_meter, velocimeter, stroemung",
    ),
}  # fmt: skip
"""Words that a proposal knows in topics of a bench, with the type and the field of the messages."""
KNOWN = """
## Words that `--guess` knows
Of columns of one thruster (`thruster_0/...`), small or capital letters, with a unit behind or without:

"""
OF_TOPICS = """
Of topics of a bench's bag. What has `cmd`, `command`, `setpoint`, `target`, `goal`, `soll` or `ref` is not measured:

"""
MORE = """
- Of two flows of one type, `inside` or `axial` is at the propeller. A topic without such a word is known by its type,
  where it alone has that: `by its type alone: is it?`
- A name may end in any unit above, in its letters alone, or in words for it: `shaft_rpm`, `F_kN`, `M_mNm`, `rev_per_s`,
  `duty_pct`, `pull_grams`, `t_usec`. `kn` of a force is kN.
- A name is tried as a whole, then what is behind each of its dots or slashes: `ahrs.roll`, `field.orientation.x`. A
  single word counts last: `roll` goes before `ekf_roll`, and `rate_roll` is no angle. What is only wanted is not
  proposed as measured (`target_rpm`, `Soll_Drehzahl`); a wanted voltage (`U_soll`) is the command. A field that is
  called as its unit, `tacho.rev_per_min`, is what its topic is called. A file's name counts where it is that of a
  message: `SCALED_IMU2.csv`, or `imu_data.csv` of `rostopic echo -p`.
- Sensors tell each other's units. An accelerometer reads gravity most of the time: 1 (g), 9.81 (m/s²), 1000 (mg) or
  981 (cm/s²). An attitude tilts as far as gravity does, and a gyro turns as the attitude does.
- `stop` of a command in counts is proposed as the commonest value, and `per_volt` as if the farthest one were full
  command: write yours. `eRPM` asks for its `scale`, 1 / pole pairs of the motor.
- All words, those of a vehicle too, are in `run_bag/importers/guess_rules.py`.
"""
OTHERS = """
## Other fields
[What each topic is](../thruster_msgs/README.md). `.x` stands for all parts of a vector or quaternion.

"""


def page() -> str:
    """Return the whole page."""
    named = [_row("channel", "unit", "what it is"), _row("---", "---", "---"), *map(_channel, channels())]
    taken = [_row("unit of the channel", "others"), _row("---", "---")]
    taken += [_row(ours, ", ".join(f"`{unit}`" for unit in others)) for ours, others in CONVERSIONS.items()]
    columns = [_row("channel", "words"), _row("---", "---"), *(_row(f"`{c}`", words) for c, words in COLUMNS.items())]
    of_topics = [_row("channel", "type, field", "words"), _row("---", "---", "---")]
    of_topics += [_row(f"`{c}`", f"`{kind}`, `{field}`", words) for c, (kind, field, words) in TOPICS.items()]
    known = KNOWN + "\n".join(columns) + "\n" + OF_TOPICS + "\n".join(of_topics) + "\n" + MORE
    return (
        HEAD
        + "\n".join(named)
        + "\n"
        + UNITS
        + "\n".join(taken)
        + "\n"
        + FOOT
        + known
        + OTHERS
        + "\n".join(_others())
        + "\n"
    )


def _others() -> list[str]:
    """Return a row for each topic of a thruster or a vehicle with the fields that are no channels, vectors as one."""
    named = {each.name for each in channels()}
    rows = [_row("topic", "fields"), _row("---", "---")]
    for topic in topics():
        fields = {re.sub(r"\.[wxyz]$", ".x", path): unit for path, unit in units().get(topic.type, {}).items()}
        shown = [
            f"`{path}` {unit}".removesuffix(" 1")
            for path, unit in fields.items()
            if not re.search(r"\[|covariance", path)
            and named.isdisjoint({f"{topic.name}.{path}", f"{topic.name}.{path}".removesuffix(".x")})
        ]
        if shown and not re.search("^/|^daq/|_enu$|/truth$", topic.name):
            rows.append(_row(f"`{topic.name}`", ", ".join(shown)))
    return rows


def unit_of_channel(channel: KnownChannel) -> str:
    """Return the unit of a channel, "" where the tables of topics and types do not know it."""
    topic, _, path = channel.name.partition(".")
    path = f"{path}.{channel.parts[0]}" if channel.parts else path
    return unit_in_map(topic_type(topic.replace("<i>", "0")) or "", path, topic.replace("<i>", "0"))


def _channel(channel: KnownChannel) -> str:
    names = [f"{channel.name}.{channel.parts[0]}", *channel.parts[1:]] if channel.parts else [channel.name]
    return _row(", ".join(f"`{name}`" for name in names), unit_of_channel(channel), channel.what)


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the page."""
    if arguments or sys.argv[1:]:
        sys.exit("usage: channels_page.py > docs/channels.md")
    print(page(), end="")


if __name__ == "__main__":
    main()
