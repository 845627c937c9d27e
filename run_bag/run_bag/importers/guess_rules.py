"""Names that suggest channels: of ArduPilot's and MAVLink's logs, of tables and bags of a thruster, of a vehicle."""

from __future__ import annotations

import re
from typing import NamedTuple

from .guessed_depth import WHICH_WATER, depth_of_pressure

__all__ = [
    "BENCH", "BY_TYPE", "BY_UNIT", "LOGS", "OF_BENCH", "OF_TYPE", "OTHER_AXES", "PX4", "SURROUNDING", "THRUSTER",
    "UNTOLD", "VEHICLE", "WHICH_FLOW", "WHOSE_ATTITUDE", "OfType", "Rule", "quoted",
]  # fmt: skip


class Rule(NamedTuple):
    """A channel, the names that suggest it, the format's unit where none is stated, and its sign there.

    {i} is the thruster's number from 0, of groups `one` or `zero` or of the name's end; {axis} that of a group `axis`,
    or the name of the group that matched. `together`: plain names that must all be there for the rule to hold.
    `alone`: no word of a longer name: rotor_temp is no rotor's speed. `entry`, `why`: as in `OfType`. `first`: the
    thruster that the name counts from.
    """

    channel: str
    names: str
    unit: str = ""
    sign: int = 1
    together: tuple[str, ...] = ()
    alone: bool = False
    entry: str = ""
    why: str = ""
    first: int = 0


_AXIS = r"(?P<axis>[xyz])"
_ANGLE = (
    r"((?P<roll>roll(en|winkel)?|phi)|(?P<pitch>pitch|nick(en|winkel)|theta)|"
    r"(?P<yaw>yaw|heading|hdg|kurs(winkel)?|gier(en|winkel)|psi))"
)
_TURN = r"((?P<x>roll)|(?P<y>pitch|nick)|(?P<z>yaw|heading|gier))"
_RATE = r"(rates?|speed|velocity|vel|gyro?)"
_GYRO = (
    r"(imu_?)?(g(yro?)?|omega|w|angular_?(rate|speed|velocity|vel)|rates?|drehrate|(dreh|winkel)geschwindigkeit)_?"
    rf"{_AXIS}"
)
_FORCE = rf"(imu_?)?(acc(el(eration)?)?|a|beschl(eunigung)?|(linear|specific)_?(acc\w*|force))_?{_AXIS}"
_RIGHT, _LEFT, _DOWN, _UP = r"starboard|stbd|stb|steuerbord", r"port|left|backbord", r"down|unten", r"up|oben"
_AHEAD = rf"(?P<x>forward|fwd|vorn|voraus)|(?P<y>{_RIGHT}|{_LEFT})|(?P<z>{_DOWN}|{_UP})"
WAYS = {1: rf"(?i)({_RIGHT}|{_DOWN})", -1: rf"(?i)(^|[\W_])({_LEFT}|{_UP})([\W_]|$)"}
"""Words of the name of a velocity to the side or down that say its axes: 1 ours, -1 REP 103's."""
_LOG_VELOCITY = (
    rf"(dvl|vel(ocity)?|v|geschwindigkeit)(_?vel(ocity)?)?_?"
    rf"({_AXIS}|(?P<x2>u)|(?P<y2>v)|(?P<z2>w)|{_AHEAD})"
)
_NAMED_VELOCITY = r"((?P<x>surge)|(?P<y>sway)|(?P<z>heave))(_?(speed|velocity|vel))?"
_BATTERY = r"(bat(t(ery|erie)?)?|akku)"
_SUPPLY = (
    rf"(supply|batt(ery|erie)?|akku|bus|[uv]_?bat\w*|vdc)(_?(volt\w*|v))?|{_BATTERY}(_?(volt\w*|spannung)|_(u|v))|voltage|"
    r"volts?|(versorgungs)?spannung"
)
_OUTPUT = r"(servo|ch(annel)?|motor|thruster|esc)_?(?P<one>\d+)_(out(put)?|pwm|cmd|command|raw)"
_CURRENT = rf"({_BATTERY}_?|supply_?)?(current|curr|amp(s|ere)?|strom)(_a)?|({_BATTERY}|supply)_(a|i)|i_?bat\w*"
_ESC = r"ESC(\[(?P<zero>\d+)\]|(?P<one>\d+))"

WHOSE_CONTROL = " of actuator_motors? of actuator_controls it is roll, pitch, yaw or thrust"
"""Asked about a PX4's control[0], which two of its topics have."""
IN_PASCALS = f"{WHICH_WATER}; in mbar before PX4 1.14: then {depth_of_pressure(100.0)}; outside the hull?"
"""Asked about a PX4's barometer."""
WHOSE_CELL = " the whole battery? of more cells than one it is the first alone"
"""Asked about a MAVLink battery's voltages[0]."""

LOGS = (
    Rule("thruster_{i}/throttle.commanded", r"RCOU\.C(?P<one>\d+)|SERVO_OUTPUT_RAW\.servo(?P<one2>\d+)_raw", "us"),
    Rule("thruster_{i}/state.n", rf"{_ESC}\.RPM", "rpm"),
    Rule("thruster_{i}/state.supply_voltage", rf"{_ESC}\.Volt", "V"),
    Rule("thruster_{i}/state.current", rf"{_ESC}\.Curr", "A"),
    *(Rule(f"thruster_{{i}}/state.{path}", rf"ESC_TELEMETRY_{k}_TO_{k + 3}\.{field}\[(?P<zero>\d)\]", unit, first=k - 1)
      for path, field, unit in (("n", "rpm", "rpm"), ("supply_voltage", "voltage", "cV"), ("current", "current", "cA"))
      for k in (1, 5, 9, 13)),
    Rule("rov/battery.voltage", r"BAT(\[0\])?\.Volt|SYS_STATUS\.voltage_battery", "V"),
    Rule("rov/battery.voltage", r"BATTERY_STATUS\.voltages\[0\]", "mV", why=WHOSE_CELL),
    Rule("rov/battery.current", r"BAT(\[0\])?\.Curr|SYS_STATUS\.current_battery", "A", -1),
    Rule("rov/battery.current", r"BATTERY_STATUS\.current_battery", "cA", -1),
    Rule("rov/imu.angular_velocity.{axis}", r"IMU(\[0\])?\.Gyr(?P<axis>[XYZ])", "rad/s"),
    Rule("rov/imu.angular_velocity.{axis}", r"(SCALED_IMU2?|RAW_IMU)\.(?P<axis>[xyz])gyro", "mrad/s"),
    Rule("rov/imu.linear_acceleration.{axis}", r"IMU(\[0\])?\.Acc(?P<axis>[XYZ])", "m/s^2"),
    Rule("rov/imu.linear_acceleration.{axis}", r"(SCALED_IMU2?|RAW_IMU)\.(?P<axis>[xyz])acc", "mg"),
    Rule("rov/odometry.pose.pose.orientation.{angle}", r"ATT\.(?P<angle>Roll|Pitch|Yaw)", "deg"),
    Rule("rov/odometry.pose.pose.orientation.{angle}", r"ATTITUDE\.(?P<angle>roll|pitch|yaw)", "rad"),
    Rule("rov/odometry.twist.twist.angular.{axis}", r"ATTITUDE\.((?P<x>roll)|(?P<y>pitch)|(?P<z>yaw))speed", "rad/s"),
    Rule("rov/depth.depth", r"CTUN\.Alt|VFR_HUD\.alt", "m", -1),
    Rule("rov/depth.depth", r"(BARO\[1\]|BAR2)\.Alt", "m", -1),
    Rule("rov/depth.depth", r"BARO(\[0\])?\.Alt", "m", -1),
    Rule("rov/depth.depth", r"SCALED_PRESSURE2\.press_abs", entry=depth_of_pressure(100.0), why=WHICH_WATER),
    Rule("rov/depth.depth", r"BARO(\[[01]\])?\.Press", entry=depth_of_pressure(1.0), why=WHICH_WATER),
)  # fmt: skip
"""Fields of ArduPilot's autopilot and of MAVLink, those first that go before others of their channel. Altitudes are
positive up, currents positive while they are drawn. An autopilot's attitude comes at times of its own, so it is no part
of the IMU's topic. An ArduSub's second barometer is the one outside."""


def _of_px4(topics: str, field: str) -> str:
    """Return the names of a field of topics of a PX4, in a bag or in files of ulog2csv: log_vehicle_attitude_0.csv."""
    return rf"(.*[_/])?({topics})(_\d+)?\.{field}"


_ELEMENT = r"\[((?P<x>0)|(?P<y>1)|(?P<z>2))\]"
PX4 = (
    Rule("rov/imu.angular_velocity.{axis}", _of_px4("sensor_combined", f"gyro_rad{_ELEMENT}"), "rad/s"),
    Rule("rov/imu.linear_acceleration.{axis}", _of_px4("sensor_combined", f"accelerometer_m_s2{_ELEMENT}"), "m/s^2"),
    Rule("rov/imu.angular_velocity.{axis}", _of_px4("vehicle_angular_velocity", f"xyz{_ELEMENT}"), "rad/s"),
    Rule("rov/imu.linear_acceleration.{axis}", _of_px4("vehicle_acceleration", f"xyz{_ELEMENT}"), "m/s^2"),
    Rule(
        "rov/odometry.pose.pose.orientation.{part}",
        _of_px4("vehicle_attitude", r"q\[((?P<w>0)|(?P<x>1)|(?P<y>2)|(?P<z>3))\]"),
        "1",
    ),
    Rule("rov/depth.depth", _of_px4("sensor_baro", "pressure"), entry=depth_of_pressure(1.0), why=IN_PASCALS),
    Rule("thruster_{i}/throttle.commanded", _of_px4("actuator_motors", r"control\[(?P<zero>\d+)\]"), "1"),
    Rule("thruster_{i}/throttle.commanded", r"output\[(?P<zero>\d+)\]"),
    Rule("thruster_{i}/throttle.commanded", r"control\[(?P<zero>\d+)\]", why=WHOSE_CONTROL),
    Rule("thruster_{i}/state.n", r"esc\[(?P<zero>\d+)\]\.esc_rpm", "rpm"),
    Rule("thruster_{i}/state.supply_voltage", r"esc\[(?P<zero>\d+)\]\.esc_voltage", "V"),
    Rule("thruster_{i}/state.current", r"esc\[(?P<zero>\d+)\]\.esc_current", "A"),
)
"""Fields of a PX4's topics. Its attitude is the vehicle's; outputs and ESCs are known without their topic's name."""

THRUSTER = (
    Rule("thruster_{i}/state.n", r"(esc|motor|thr(uster)?|prop)_?(k?rpm|rps|revs?)"),
    Rule("thruster_{i}/throttle.commanded", _OUTPUT),
    Rule("thruster_{i}/throttle.commanded", r"(servo|out(put)?)_?(?P<one>\d+)"),
    Rule("thruster_{i}/throttle.commanded", r"(throttle|command|cmd|pwm|u)(_?(in|out|signal|v|us|cmd))?"),
    Rule("thruster_{i}/throttle.commanded", r"dac(_?(out|counts?))?"),
    Rule("thruster_{i}/throttle.commanded", r"esc(_?(in|out|signal|v|us|cmd))?", alone=True),
    Rule("thruster_{i}/throttle.commanded", r"setpoint|drive|soll|(soll|stell)wert|stellgr(ö|oe)(ß|ss)e", alone=True),
    Rule("thruster_{i}/state.n", r"(n|k?rpm|rps|omega|tach\w*|(rotor|motor|prop\w*|rotational)_?(speed|rpm)|speed)"),
    Rule("thruster_{i}/state.n", r"rotor", alone=True),
    Rule("thruster_{i}/state.n", r"(motor|propeller)?_?drehzahl(messer|geber)?|drehgeber"),
    Rule("thruster_{i}/load.wrench.force.x", r"schub(kraft)?|kraft(messdose|sensor|aufnehmer)?"),
    Rule("thruster_{i}/load.wrench.torque.x", r"dreh_?moment"),
    Rule("thruster_{i}/load.wrench.force.x", r"(thrust|force|load|load_?cell|f_?x|fx)(_measured|_x)?"),
    Rule("thruster_{i}/load.wrench.torque.x", r"(torque|moment|q|m_?x|mx)(_measured|_x)?"),
    Rule("thruster_{i}/flow.ambient", r"(ambient|flow|water|inflow|stream)(_?(speed|flow|velocity))?"),
    Rule("thruster_{i}/flow.ambient", r"adv", alone=True),
    Rule("thruster_{i}/flow.ambient", r"(an|zu)?str(ö|oe)mung(s_?geschwindigkeit)?"),
    Rule("thruster_{i}/flow.axial", r"(axial|duct)(_?(speed|flow|velocity))?"),
    Rule("thruster_{i}/state.supply_voltage", _SUPPLY),
    Rule("thruster_{i}/throttle.commanded", r"voltage|volts?|spannung"),
    Rule("thruster_{i}/state.current", r"(current|curr|amp(s|ere)?|i|strom)(_a)?"),
)
"""Of tables and other bags: the whole name, or its last part."""

_ASKED = r"soll|set(_?point)?|ref|cmd|command(ed)?"
_INSIDE, _OUTSIDE, _OF_WATER = (
    r"(inside|innen|d(ü|ue)se|nozzle)",
    r"(outside|au(ß|ss)en|tank|tunnel)",
    r"(v|vel|flow|str(ö|oe)mung)",
)
BENCH = (
    Rule("thruster_{i}/throttle.commanded", rf"(u|duty|spannung|voltage|volts?)_?({_ASKED})|soll_?(u|spannung)"),
    Rule("thruster_{i}/throttle.commanded", r"duty(_?cycle)?|(joy_?)?stick"),
    Rule("thruster_{i}/state.n", r"enc(oder)?", alone=True, why=" a speed? an encoder's angle is none"),
    Rule("thruster_{i}/state.n", r"revs", alone=True, why=" a speed? a count of turns is none"),
    Rule("thruster_{i}/state.n", r"shaft", alone=True),
    Rule("thruster_{i}/load.wrench.force.x", r"pull|zugkraft", alone=True),
    Rule("thruster_{i}/flow.axial", rf"{_OF_WATER}_?{_INSIDE}|{_INSIDE}_?{_OF_WATER}", alone=True),
    Rule("thruster_{i}/flow.ambient", rf"{_OF_WATER}_?{_OUTSIDE}|{_OUTSIDE}_?{_OF_WATER}", alone=True),
    Rule("thruster_{i}/flow.axial", _INSIDE, alone=True, why=" a flow?"),
    Rule("thruster_{i}/flow.ambient", _OUTSIDE, alone=True, why=" a flow?"),
    Rule("thruster_{i}/flow.ambient", r"vel(ocity)?_[cm]m(_?s)?", alone=True),
)
"""Of tables and bags without a vehicle, before the others: a vehicle's u may be its speed, its encoder an arm's. A unit
of something else denies them where it is stated."""

BY_UNIT = {
    "rad/s": "thruster_{i}/state.n",
    "N": "thruster_{i}/load.wrench.force.x",
    "N m": "thruster_{i}/load.wrench.torque.x",
    "%": "thruster_{i}/throttle.commanded",
    "us": "thruster_{i}/throttle.commanded",
}
"""Units that leave little doubt in a table of one thruster, whatever a column is called -> the channel."""

SURROUNDING = r"(?i)ambient|outside|au(ß|ss)en|tank|tunnel"
"""Words of a name that say that a flow is of the water around."""

WHICH_FLOW = " of the water around? at the propeller it is flow.axial"
"""Asked where a name says that it is a flow, and not which."""

OTHER_AXES = " where are its other axes? a diagnosis reads all three or none"
"""Asked about a velocity log of which not all axes are recognised."""

WHOSE_ATTITUDE = " of this IMU? the vehicle's own, as an autopilot tells it, is rov/odometry.pose.pose.orientation"
"""Asked where an attitude comes at other times than the gyro."""

VEHICLE = (
    Rule("rov/odometry.pose.pose.orientation.{part}", r"(pose_){1,2}orientation_(?P<part>[wxyz])", "1"),
    Rule("rov/imu.orientation.{part}", r"(att(itude)?_?)?(q|quat(ernion)?|orientation)_?(?P<part>[wxyz])", "1"),
    Rule("rov/imu.orientation.{angle}", rf"(att(itude)?_?|euler_?)?{_ANGLE}(_angle)?"),
    Rule("rov/imu.angular_velocity.{axis}", _GYRO),
    Rule("rov/imu.angular_velocity.{axis}", rf"{_AXIS}_?gyro"),
    Rule("rov/imu.angular_velocity.{axis}", rf"{_TURN}_?{_RATE}"),
    Rule("rov/imu.angular_velocity.{axis}", rf"{_RATE}_?{_TURN}"),
    Rule("rov/imu.angular_velocity.{axis}", r"(?P<x>p)|(?P<y>q)|(?P<z>r)", together=("p", "q", "r")),
    Rule("rov/imu.linear_acceleration.{axis}", _FORCE),
    Rule("rov/imu.linear_acceleration.{axis}", rf"{_AXIS}_?acc(el)?"),
    Rule("rov/imu.linear_acceleration.{axis}", r"f(?P<axis>[xyz])", together=("fx", "fy", "fz")),
    Rule("rov/velocity.twist.twist.linear.{axis}", _LOG_VELOCITY),
    Rule("rov/velocity.twist.twist.linear.{axis}", rf"log_?({_AHEAD})"),
    Rule("rov/velocity.twist.twist.linear.{axis}", _NAMED_VELOCITY),
    Rule("rov/velocity.twist.twist.linear.{axis}", rf"((twist_){{1,2}}linear|bottom_?track)_{_AXIS}"),
    Rule("rov/velocity.twist.twist.linear.{axis}", r"(?P<x>u)|(?P<y>v)|(?P<z>w)", together=("u", "v", "w")),
    Rule("rov/depth.depth", r"(depth|dpth)(_sensor)?|(tauch)?tiefe|z_?(ned|down)"),
    Rule("rov/depth.depth", r"z_?(enu|up)", "", -1),
    Rule("rov/depth.depth", r"fluid_pressure", entry=depth_of_pressure(1.0), why=WHICH_WATER),
    Rule("rov/battery.current", _CURRENT, "", -1),
    Rule("rov/battery.voltage", _SUPPLY),
)  # fmt: skip
"""Of tables of a vehicle: those with several thrusters, or with a gyro."""


class OfType(NamedTuple):
    """A field of some types of messages, on topics of some names, and the channel of ours that holds the same.

    {path} is the field, {i} and {part} are groups of it. unit: the type's, where no recording states it; entry,
    why: the rest of a map's entry, where nothing is left to guess, and what is to be asked about it.
    """

    types: str
    path: str
    channel: str
    topics: str = ""
    unit: str = ""
    entry: str = ""
    why: str = ""


_MEASURED = (
    r"(?i)^(?!.*(cmd|command|set_?point|target|desired|wanted|demand|goal|(^|[/_])(soll|ref(erence)?([/_]|$)))).*"
)
_SENT = r"(?i)(cmd|command|throttle|set_?point|(^|[/_])soll|stell(wert|gr))"
_LOG, _ROTORS = rf"{_MEASURED}(dvl|doppler|bottom|veloc|twist)", rf"{_MEASURED}(thruster|motor|rotor|prop|esc|rpm)"
_TWIST = r"(pose\.pose\.(orientation\.[wxyz]|position\.[xyz])|twist\.twist\.(linear|angular)\.[xyz])"
_PUSH = rf"{_MEASURED}(load|cell|force|wrench|thrust|(^|[/_])ft([/_]|$))"
_SHAFT = rf"{_MEASURED}(encoder|tach|drive|drehzahl|((^|[/_])(thr|shaft|welle)([/_]|$)))"
_AMBIENT = rf"{_MEASURED}(ambient|adv|flow|current_?meter|water|str(ö|oe)mung|velocimeter|outside|tank|tunnel)"
_FLOWS, _ALONG = r"geometry_msgs/msg/(Twist|Vector3)(Stamped)?", r"(twist\.)?linear\.x|(vector\.)?x"
_OURS = "rov/velocity.twist.twist.linear"
_IMU = r"(orientation\.[wxyz]|(angular_velocity|linear_acceleration)\.[xyz])"
_LOAD, _SPEEDS = r"(wrench\.)?(?P<part>(force|torque)\.x)", r"velocity\[(?P<i>\d+)\]"
OF_BENCH = (
    OfType(r"geometry_msgs/msg/Wrench(Stamped)?", _LOAD, "thruster_0/load.wrench.{part}", _PUSH),
    OfType(_FLOWS, _ALONG, "thruster_0/flow.axial", rf"{_MEASURED}(axial|duct|inside)", "m/s"),
    OfType(_FLOWS, _ALONG, "thruster_0/flow.ambient", _AMBIENT, "m/s"),
    OfType(r"sensor_msgs/msg/JointState", _SPEEDS, "thruster_{i}/state.n", _SHAFT, "rad/s"),
)
"""Of bags without a vehicle, before the others: a bench's load cell and current meters, along x, and its rotor."""
_ALONE = " by its type alone: is it?"
BY_TYPE = (
    OfType(r"geometry_msgs/msg/WrenchStamped", _LOAD, "thruster_0/load.wrench.{part}", _MEASURED, why=_ALONE),
    OfType(r"geometry_msgs/msg/TwistStamped", _ALONG, "thruster_0/flow.ambient", _MEASURED, why=_ALONE),
    OfType(r"sensor_msgs/msg/JointState", r"velocity\[0\]", "thruster_0/state.n", _MEASURED, "rad/s", why=_ALONE),
)
"""Of a bench's bags: what the one topic of its type is, whatever it is called."""
OF_TYPE = (
    OfType(r"sensor_msgs/msg/Imu", _IMU, "rov/imu.{path}"),
    OfType(r"nav_msgs/msg/Odometry", _TWIST, "rov/odometry.{path}"),
    OfType(r"geometry_msgs/msg/TwistWithCovarianceStamped", r"twist\.twist\.linear\.[xyz]", "rov/velocity.{path}"),
    OfType(r"geometry_msgs/msg/Twist(Stamped)?", r"(twist\.)?linear\.(?P<part>[xyz])", f"{_OURS}.{{part}}", _LOG),
    OfType(r"geometry_msgs/msg/Vector3Stamped", r"vector\.(?P<part>[xyz])", f"{_OURS}.{{part}}", _LOG, "m/s"),
    OfType(r"sensor_msgs/msg/JointState", _SPEEDS, "thruster_{i}/state.n", _ROTORS, "rad/s"),
    OfType(r"sensor_msgs/msg/JointState", r"effort\[(?P<i>\d+)\]", "thruster_{i}/throttle.commanded", _SENT),
    OfType(r"sensor_msgs/msg/BatteryState", r"voltage|current", "rov/battery.{path}"),
    OfType(
        r"sensor_msgs/msg/FluidPressure", r"fluid_pressure", "rov/depth.depth", entry=depth_of_pressure(1.0),
        why=WHICH_WATER,
    ),
    OfType(r"geometry_msgs/msg/PointStamped", r"point\.z", "rov/depth.depth", rf"{_MEASURED}(depth|tiefe)", "m"),
    OfType(r"thruster_msgs/msg/Depth", r"depth", "rov/depth.{path}"),
)  # fmt: skip
"""Fields of bags whose type tells what they are, whatever a topic is called."""
UNTOLD = re.compile(
    r"covariance\[|(^|\.)layout\.|\.variance$|(^|\.)header\.|^(FMTU|UNIT|MULT)\.|\.time_(usec|boot_ms)$"
)
"""Fields of messages that no channel holds: nobody looks for them among what was not recognised."""


def quoted(text: str) -> str:
    """Return a text as YAML that is read back as that text."""
    plain = re.fullmatch(r"[A-Za-z_/][\w./ ^-]*[\w]|[A-Za-z_/]", text) and text.lower() not in ("null", "true", "false")
    return text if plain else "'" + " ".join(text.split()).replace("'", "''") + "'"
