"""Recordings without a controller file: open loop, ambient, reversal, in air."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt

from ..errors import RecordingError
from ..topic import Topic
from .bench_files import LoadCellFile, VelocimeterFile
from .decisions import Decisions
from .flow import flow_topics
from .load_cell import FRAME, describe_clock, describe_tachometer, load_topics, stamps
from .options import BenchOptions, throttle_from_name
from .programme import programme
from .ramp import fit_ramp
from .signals import LEAST_REST, REST_MARGIN, period, smooth, takes_both_signs
from .wrench import LEAST_THRUST, forward_thrust, turns

Array = NDArray[np.float64]
LEAST_THROTTLE = 0.5  # [V] beyond which, to both sides, the last column cannot be the unsigned tachometer
CUTOFF = 20.0  # [Hz] of the smoothed throttle
SIGN_INFERRED = 2


def open_loop_topics(
    stem: str,
    csv: LoadCellFile,
    dat: VelocimeterFile | None,
    options: BenchOptions,
    log: Decisions,
    in_air: bool,
) -> list[Topic]:
    """Return the topics of one recording.

    Args:
        in_air: the name of the recording or its folder says so.

    Raises:
        RecordingError: the throttle can neither be read off the recording nor its name.
    """
    describe_clock(csv, log)
    if takes_both_signs(csv.time, csv.last, LEAST_THROTTLE):
        topics, sign, direction, rest = _measured_throttle(csv, options, log)
    else:
        topics, sign, direction, rest = _reconstructed_throttle(stem, csv, options, log)
    _water(csv, direction, rest, options, log, in_air)
    topics += load_topics(csv, direction, rest, options, log)
    if dat is not None:
        topics += flow_topics(stem, dat, csv.time, sign, options, log)
    return topics


def _measured_throttle(
    csv: LoadCellFile, options: BenchOptions, log: Decisions
) -> tuple[list[Topic], float, Array, tuple[float, float] | None]:
    raw = csv.last
    log.add(
        "last column",
        "throttle",
        "V",
        "it takes both signs well beyond its noise, which the tachometer cannot",
    )
    b, a = butter(2, min(0.99, CUTOFF * 2 * period(csv.time)))
    clean = filtfilt(b, a, raw)
    noise = float(np.std(raw - clean))
    log.add("throttle, commanded", "smoothed", "V",
            f"second-order low pass of {CUTOFF:g} Hz without delay; `sent` holds the column as recorded",
            noise)  # fmt: skip
    largest = float(np.max(np.abs(clean)))
    if largest > options.throttle_limit + 6 * noise:
        text = (
            f"last column: expected a throttle of at most {options.throttle_limit:g} V, as the device takes, found "
            f"{largest:.3g} V; --throttle-limit VOLTS tells another device"
        )
        raise RecordingError(text, expected=options.throttle_limit, found=largest)
    moved = np.flatnonzero(np.abs(clean) > max(6 * noise, 0.1))
    end = float(csv.time[moved[0]]) - REST_MARGIN if moved.size else float(csv.time[-1])
    rest = (float(csv.time[0]), end) if end - csv.time[0] >= LEAST_REST else None
    log.add(
        "rest window",
        None if rest is None else list(rest),
        "s",
        "from the first sample to 0.2 s before the throttle",
    )
    fast = np.abs(clean) > 2 / 3 * float(np.max(np.abs(clean)))
    direction = np.where(fast, np.sign(clean), 0.0)
    topic = Topic(name="thruster_0/throttle", type="thruster_msgs/Throttle", stamps=stamps(csv.time),
                  fields={"commanded": clean, "sent": raw}, frame=FRAME)  # fmt: skip
    return [topic], float(np.sign(clean[np.argmax(np.abs(clean))])), direction, rest


def _reconstructed_throttle(
    stem: str, csv: LoadCellFile, options: BenchOptions, log: Decisions
) -> tuple[list[Topic], float, Array, tuple[float, float] | None]:
    named = throttle_from_name(stem)
    setting = named if options.throttle_set is None else options.throttle_set
    if not setting:
        text = f"{stem}: expected a name ending in a throttle (p3V, m2.5V), or --throttle-set, found neither"
        raise RecordingError(text, expected="p3V", found=stem)
    source = "told by the user" if options.throttle_set is not None else "from the name of the recording"
    log.add("throttle at the plateau", setting, "V", source)
    if abs(setting) > options.throttle_limit:
        text = (
            f"{stem}: expected a throttle of at most {options.throttle_limit:g} V, as the device takes, found "
            f"{setting:g} V {source}; --throttle-set VOLTS tells another one, --throttle-limit VOLTS another device"
        )
        raise RecordingError(text, expected=options.throttle_limit, found=setting)
    sign = float(np.sign(setting))
    edge = options.dead_zone_edge[0] if sign < 0 else options.dead_zone_edge[1]
    log.add("edge of the dead zone", edge, "V", "option")
    if abs(setting) <= abs(edge):
        text = f"{stem}: expected a throttle beyond the edge of the dead zone, {edge:g} V, found {setting:g} V"
        raise RecordingError(text, expected=edge, found=setting)
    speed = options.tachometer_gain * csv.last
    log.add("tachometer gain", options.tachometer_gain, "rad/s/V", "constant of the bench (option)")
    rest = describe_tachometer(csv.time, speed, log)
    ramp = fit_ramp(csv.time, speed, where=stem)
    fitted = "least-squares fit of a ramp behind a first-order lag to |n|"
    log.add("start of the ramp", ramp.start, "s", fitted, ramp.start_std)
    log.add("duration of the ramp", ramp.duration, "s", fitted, ramp.duration_std)
    log.add("lag of the rotor", ramp.lag, "s", fitted, ramp.lag_std)
    log.add("plateau of n above rest", ramp.plateau, "rad/s", fitted, ramp.residual)
    log.add(
        "shutdown",
        ramp.shutdown,
        "s",
        "line through the first fall of |n| meets the plateau",
        ramp.shutdown_std,
    )
    log.add("sign of n", sign, "1", "inferred from the throttle; the tachometer is unsigned")
    commanded = programme(ramp, setting, edge, log).throttle(csv.time)
    at = stamps(csv.time)
    count = len(at)
    topics = [
        Topic(name="thruster_0/state", type="thruster_msgs/ThrusterState", stamps=at, frame=FRAME,
              fields={"n": sign * speed, "sign_source": np.full(count, SIGN_INFERRED)}),
        Topic(name="thruster_0/throttle", type="thruster_msgs/Throttle", stamps=at, frame=FRAME,
              fields={"commanded": commanded}),
    ]  # fmt: skip
    return topics, sign, turns(csv.time, speed, np.full(count, sign)), rest


def _water(
    csv: LoadCellFile,
    direction: Array,
    rest: tuple[float, float] | None,
    options: BenchOptions,
    log: Decisions,
    in_air: bool,
) -> None:
    if options.water is not None:
        log.add("water", options.water, "1", "told by the user")
        return
    if in_air:
        log.add("water", False, "1", "run in air: the name of the recording or its folder says so")
        return
    level = 0.0
    if rest is not None:
        window = (csv.time >= rest[0]) & (csv.time <= rest[1])
        level = float(np.mean(csv.force[window, 1]))
    found = forward_thrust(csv.time, smooth(-csv.force[:, 1], csv.time, 0.1), -level, direction)
    if found is None:
        log.add("water", True, "1", "assumed: too little rotation above 50 rad/s to tell")
    else:
        water = abs(found[0]) >= LEAST_THRUST
        how = f"mean thrust above 50 rad/s is {found[0]:.2f} N; below {LEAST_THRUST:g} N is taken as air"
        log.add("water", water, "1", how if water else f"run in air: {how}")
