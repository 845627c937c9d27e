"""Recordings with a controller file: the controller's signals, and the load cell's on the same clock."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import RecordingError
from ..topic import Topic
from .bench_files import MAT_PERIOD, ControllerFile, LoadCellFile
from .clocks import match
from .decisions import Decisions
from .load_cell import FRAME, describe_clock, describe_tachometer, load_topics, stamps
from .open_loop import SIGN_INFERRED
from .options import BenchOptions, estimator_from_name
from .sign_source import SIGN_UNKNOWN
from .signals import infer_sign, sign_unknown
from .wrench import turns


def closed_loop_topics(
    stem: str, csv: LoadCellFile, mat: ControllerFile, options: BenchOptions, log: Decisions
) -> list[Topic]:
    """Return the topics of one recording; the csv's clock is the common one."""
    describe_clock(csv, log)
    speed = options.tachometer_gain * csv.last
    log.add("tachometer gain", options.tachometer_gain, "rad/s/V", "constant of the bench (option)")
    rest = describe_tachometer(csv.time, speed, log)
    u, n = mat.series["u"], mat.series["n"]
    time = np.asarray(MAT_PERIOD * np.arange(len(u) + 1), dtype=np.float64)
    lasts, longest = time[-2] - time[0], csv.time[-1] - csv.time[0]
    if lasts > longest:
        text = f"{stem}: expected the csv to cover the controller's recording of {lasts:g} s; found {longest:g} s"
        raise RecordingError(text, expected=float(lasts), found=float(longest))
    offset, deviation, left = match(csv.time, speed, time[:-1], n)
    how = f"both tachometer signals matched below a sample; {left:.2f} rad/s of mean absolute difference left"
    log.add("start of the controller's recording", offset, "s", how, deviation)
    log.add("sample period of the controller", MAT_PERIOD, "s", "constant of the bench")
    log.add("instant of y[k] relative to u[k]", None, "s", "not recorded; both are stamped alike")
    at, longer = stamps(time[:-1], offset), stamps(time, offset)

    edge = max(map(abs, options.dead_zone_edge))
    sign = infer_sign(time[:-1], n, u, edge)
    how = f"that of u, switching at the least |n| between u's change of sign and 0.25 s beyond {edge:g} V"
    unsure = sign_unknown(time[:-1], n, u, sign, edge)
    log.add("sign of n", "inferred", "1", how)
    index = np.clip(np.searchsorted(time[:-1] + offset, csv.time, side="right") - 1, 0, len(u) - 1)
    acting = np.where(csv.time < offset, 0.0, u[index])
    dense = infer_sign(csv.time, speed, acting, edge)
    dense_unsure = sign_unknown(csv.time, speed, acting, dense, edge)
    how = "from its least until the throttle has left the dead zone and |n| has risen again; sign_source says so"
    share = float(np.mean(dense_unsure))
    log.add("samples of which nothing tells the sign of n", share, "1", f"share, about reversals: {how}")
    topics = [
        _topic("thruster_0/thrust_setpoint", "ThrustSetpoint", at, {"thrust": mat.series["Td"]}),
        _throttle(csv, at, u, log),
        _topic("thruster_0/state", "ThrusterState", at,
               _signed(n, sign, unsure)),
        _topic("daq/thruster_0/state", "ThrusterState", stamps(csv.time),
               _signed(speed, dense, dense_unsure)),
    ]  # fmt: skip
    if "nd" in mat.series:
        topics.append(_topic("thruster_0/speed_setpoint", "SpeedSetpoint", at, {"n": mat.series["nd"]}))
    if "ambient" in mat.series:
        topics.append(_topic("thruster_0/flow", "FlowVelocity", at, {"ambient": mat.series["ambient"]}))
    if "nhat" in mat.series:
        topics.append(_estimate(stem, longer, mat, log))
    topics += load_topics(csv, turns(csv.time, speed, dense), rest, options, log)
    log.add(
        "water",
        options.water is not False,
        "1",
        "told by the user" if options.water is not None else "assumed",
    )
    return topics


def _topic(name: str, kind: str, at: Any, fields: dict[str, Any]) -> Topic:
    return Topic(name=name, type=f"thruster_msgs/{kind}", stamps=at, fields=fields, frame=FRAME)


def _signed(magnitude: Any, sign: Any, unsure: Any) -> dict[str, Any]:
    """Return the fields of a speed: with its sign where that was inferred, else as a magnitude."""
    return {
        "n": np.where(unsure, magnitude, sign * magnitude),
        "sign_source": np.where(unsure, SIGN_UNKNOWN, SIGN_INFERRED),
    }


def _throttle(csv: LoadCellFile, at: Any, u: Any, log: Decisions) -> Topic:
    """Return the throttle; outside the controller's recording it was 0 V, which the log did not say."""
    first, last = stamps(csv.time[[0, -1]])
    end = at[-1] + round(MAT_PERIOD * 1e9)
    before, after = int(first < at[0]), int(last >= end)
    at = np.concatenate([[first] * before, at, [end] * after]).astype(np.int64)
    values = np.concatenate([[0.0] * before, u, [0.0] * after])
    log.add("throttle outside the controller's recording", 0.0, "V", "one message before and one after it, added")
    return _topic("thruster_0/throttle", "Throttle", at, {"commanded": values})


def _estimate(stem: str, at: Any, mat: ControllerFile, log: Decisions) -> Topic:
    fields: dict[str, Any] = {"n": mat.series["nhat"], "estimator": estimator_from_name(stem)}
    for source, field in (("vhat", "v"), ("vahat", "ambient")):
        if source in mat.series:
            fields[field] = mat.series[source]
    if mat.covariance is not None:
        fields["covariance"] = mat.covariance.reshape(-1, 9)
        kept = "n, v, U" if np.isfinite(mat.covariance).all() else "n only"
        log.add("covariance of the estimate", kept, "", "as far as the controller kept it")
    log.add("estimator", fields["estimator"], "", "from the name of the recording")
    log.add(
        "last sample of the estimate",
        "prediction",
        "",
        "one sample longer than the other signals, as recorded",
    )
    return _topic("thruster_0/estimate", "ThrusterEstimate", at, fields)
