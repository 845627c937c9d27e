"""Topics of the velocimeter: the flow along the thruster, and everything it recorded."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..topic import Topic
from .bench_files import VelocimeterFile
from .decisions import Decisions
from .load_cell import stamps
from .options import BenchOptions

WINDOW_AGREEMENT = 0.02
"""[s] to which windows chosen by hand in both recordings agree with a common start."""


def flow_topics(
    stem: str,
    dat: VelocimeterFile,
    csv_time: NDArray[np.float64],
    sign: float,
    options: BenchOptions,
    log: Decisions,
) -> list[Topic]:
    """Return flow and raw samples; `sign` is that of the throttle.

    Raises:
        RecordingError: the offset puts the recording before the start of the clock or beside the load cell's, or
            nothing tells it.
    """
    kind = options.adv or ("ambient" if "ambient" in stem.lower() else "axial")
    log.add("flow measured", kind, "", "told by the user" if options.adv else "from the name of the recording")
    time = dat.time - dat.time[0]
    longer = float(time[-1] - (csv_time[-1] - csv_time[0]))
    step = float(np.median(np.diff(time)))
    shorter = float(min(time[-1], csv_time[-1] - csv_time[0]))
    if options.adv_offset is None and abs(longer) > shorter:
        text = (
            f"{stem}: expected velocimeter and load cell to start together and last about as long, found "
            f"{time[-1]:.4g} and {csv_time[-1] - csv_time[0]:.4g} s; --adv-offset SECONDS tells where the first begins"
        )
        raise RecordingError(text, expected=shorter, found=longer)
    if options.adv_offset is None:
        how = f"both recordings taken to start together; the velocimeter's is {longer:+.3f} s longer"
        log.add("offset of the velocimeter's clock", 0.0, "s", how, float(np.hypot(WINDOW_AGREEMENT, longer / 2)))
        offset = float(csv_time[0])
    else:
        log.add("offset of the velocimeter's clock", options.adv_offset, "s", "told by the user")
        offset = float(csv_time[0]) + options.adv_offset
    if offset < -1.0:
        raise RecordingError(
            f"expected an offset of the velocimeter of at least -1 s, found {offset:g} s", found=offset
        )
    if offset > csv_time[-1] or offset + time[-1] < csv_time[0]:
        text = (
            f"{stem}: expected the velocimeter's recording to overlap the load cell's, {csv_time[0]:g} to "
            f"{csv_time[-1]:g} s; found {offset:g} to {offset + time[-1]:g} s on its clock, by --adv-offset"
        )
        raise RecordingError(text, expected=[float(csv_time[0]), float(csv_time[-1])], found=offset)
    lost = np.round(np.diff(time) / step).astype(int) - 1
    if (lost > 0).any():
        log.add("velocimeter samples missing", int(lost[lost > 0].sum()), "1", "from gaps in its time column")
    log.add(
        "sign of the flow",
        sign,
        "1",
        "X times the sign of the throttle: X is positive along the flow either way",
    )
    at = stamps(time, offset)
    velocity = sign * dat.velocity[:, 0]
    flow = {kind: velocity, "quality": np.clip(dat.correlation.mean(axis=1) / 100, 0, 1)}
    raw = {
        "counter": dat.counter, "status": dat.status, "velocity": dat.velocity,
        "amplitude": dat.amplitude, "snr": dat.snr, "correlation": dat.correlation,
    }  # fmt: skip
    return [
        Topic(
            name="thruster_0/flow",
            type="thruster_msgs/FlowVelocity",
            stamps=at,
            fields=flow,
            frame="thruster_0",
        ),
        Topic(name="thruster_0/adv_raw", type="thruster_msgs/AdvSample", stamps=at, fields=raw, frame="adv"),
    ]
