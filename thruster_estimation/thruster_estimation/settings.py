"""What each observer assumes: a named tuple per observer, whose class chooses the observer.

Process noise is given as densities, measurement noise as the variance of one sample. The bench's form is written with
densities of both: there R = r dt. A sample's variance r at period dt and the density R = r dt are the same noise.
"""

from math import inf, isfinite
from typing import Any, NamedTuple

__all__ = [
    "BENCH", "OBSERVERS", "PERIOD", "PROPER", "EkfSettings", "KfnloSettings", "NloSettings", "SpeedEkfSettings",
    "bench_settings", "checked",
]  # fmt: skip

PROPER = 0
"""The period is integrated (RK4 and matrix exponential), then corrected by the measurement at its end."""
BENCH = 1
"""Explicit Euler of the continuous filter as the bench ran it: throttle and measurement of the beginning.

Neither gate nor ceilings: every usable measurement is used."""
PERIOD = 0.04
"""Period of the bench [s]."""


class SpeedEkfSettings(NamedTuple):
    """Extended Kalman filter of the rotor speed alone; v and U stay what they are.

    Attributes:
        q_n: density of the process noise [rad^2/s^3].
        r_n: variance of a measured speed [rad^2/s^2].
        unsigned: 1: the tachometer measures |n|; 0: it is signed.
        gate: largest NIS of a measurement that is used, chi-square with one degree of freedom; inf: all are.
        patience: time [s] of refusals in a row after which the next one is used and the covariance widened to it.
        stale: time [s] without a used measurement after which the status says so.
        largest_n: ceiling of the deviation [rad/s].
        unknown_drive: deviation of the drive gamma(u) [rad/s^2] while the throttle is not known.
        largest_step: upper bound of the integration's steps [s].
        form: PROPER or BENCH.
    """

    q_n: float
    r_n: float
    unsigned: int = 1
    gate: float = inf
    patience: float = 0.5
    stale: float = 0.5
    largest_n: float = 300.0
    unknown_drive: float = 1000.0
    largest_step: float = 1e-2
    form: int = PROPER


class EkfSettings(NamedTuple):
    """Extended Kalman filter of n, v, U; further fields as in `SpeedEkfSettings`.

    Attributes:
        q_n, q_v, q_U: densities of the process noise [rad^2/s^3, m^2/s^3, m^2/s^3].
        r_n, r_U: variances of a measured speed [rad^2/s^2] and of a measured ambient flow [m^2/s^2].
        largest_n, largest_v, largest_U: ceilings of the deviations [rad/s, m/s, m/s].
    """

    q_n: float
    q_v: float
    q_U: float
    r_n: float
    r_U: float
    unsigned: int = 1
    gate: float = inf
    patience: float = 0.5
    stale: float = 0.5
    largest_n: float = 300.0
    largest_v: float = 0.3
    largest_U: float = 0.5
    unknown_drive: float = 1000.0
    largest_step: float = 1e-2
    form: int = PROPER


class NloSettings(NamedTuple):
    """Nonlinear observer (4.16), (4.17) of v and U beside the filter of n; further fields as in `SpeedEkfSettings`.

    Attributes:
        k_11, k_21: linear gains of v and U [1/s].
        k_12, k_22: gains per rotor speed [1].
        largest_innovation: largest |y - U| that is used [m/s].
        printed: 1: the inflow is sgn(n) y as printed in (4.16); 0: |v| U as in (4.4), as the bench ran it.
    """

    q_n: float
    r_n: float
    k_11: float
    k_12: float
    k_21: float
    k_22: float
    unsigned: int = 1
    gate: float = inf
    largest_innovation: float = inf
    patience: float = 0.5
    stale: float = 0.5
    largest_n: float = 300.0
    unknown_drive: float = 1000.0
    printed: int = 1
    largest_step: float = 1e-2
    form: int = PROPER


class KfnloSettings(NamedTuple):
    """The nonlinear observer with Kalman gains; further fields as in `EkfSettings` and `NloSettings`.

    Attributes:
        k_11, k_21: linear gains in addition to the Kalman gains [1/s]: the bench's; 0 in the thesis' sense.
        saturate: 1: the gains from the ambient flow are kept within (4.18), (4.19).
    """

    q_n: float
    q_v: float
    q_U: float
    r_n: float
    r_U: float
    k_12: float
    k_22: float
    k_11: float = 0.0
    k_21: float = 0.0
    saturate: int = 0
    unsigned: int = 1
    gate: float = inf
    patience: float = 0.5
    stale: float = 0.5
    largest_n: float = 300.0
    largest_v: float = 0.3
    largest_U: float = 0.5
    unknown_drive: float = 1000.0
    printed: int = 1
    largest_step: float = 1e-2
    form: int = PROPER


OBSERVERS: dict[str, Any] = {
    "ekf": EkfSettings, "nlo": NloSettings, "kfnlo": KfnloSettings, "speed-ekf": SpeedEkfSettings,
}  # fmt: skip
"""Settings class of each observer by its name."""
_FLAGS = ("unsigned", "printed", "saturate", "form")
_MAY_BE_INFINITE = ("gate", "largest_innovation", "patience", "stale")
_ANY_SIGN = ("k_11", "k_12", "k_21", "k_22")
_MAY_BE_ZERO = ("q_n", "q_v", "q_U", "unknown_drive", *_FLAGS)


def checked(settings: Any) -> Any:
    """Return the settings with floats and integers where kernels expect them.

    Raises:
        ValueError: with all fields that no observer can work with.
    """
    wrong = []
    for name, value in settings._asdict().items():
        if not (isfinite(value) or (name in _MAY_BE_INFINITE and value == inf)):
            wrong.append(f"{name}: expected a finite number, got {value}")
        elif name in _FLAGS and value not in (0, 1):
            wrong.append(f"{name}: expected 0 or 1, got {value}")
        elif name not in _ANY_SIGN and (value < 0 or (value == 0 and name not in _MAY_BE_ZERO)):
            wrong.append(f"{name}: expected a number {'>= 0' if name in _MAY_BE_ZERO else '> 0'}, got {value}")
    if wrong:
        raise ValueError(f"{type(settings).__name__}: {'; '.join(wrong)}")
    typed = {name: int(x) if name in _FLAGS else float(x) for name, x in settings._asdict().items()}
    return type(settings)(**typed)


def bench_settings(observer: str, *, form: int = PROPER, k_U: float = 0.2395923, dt: float = PERIOD) -> Any:
    """Return the bench's numbers for an observer of `OBSERVERS`.

    The bench's R = diag(3, 0.005) and Q = diag(300, 0.002, 0.002) are densities; a sample every `dt` [s] has R / dt.
    Gains k_11 = 0.1 + k_U, k_12 = 0.1, k_21 = 0.6, k_22 = 0.1. In the bench's form KFNLO adds all four to the Kalman
    gains, and the inflow is that of (4.4); in the proper form both follow the thesis. Nothing is gated.

    Raises:
        ValueError: an observer that there is not.
    """
    if observer not in OBSERVERS:
        raise ValueError(f"observer: expected one of {', '.join(OBSERVERS)}, got {observer!r}")
    speed = {"q_n": 300.0, "r_n": 3.0 / dt, "form": form}
    flow = {"q_v": 0.002, "q_U": 0.002, "r_U": 0.005 / dt}
    linear, cubic = {"k_11": 0.1 + k_U, "k_21": 0.6}, {"k_12": 0.1, "k_22": 0.1}
    as_run = form == BENCH
    chosen: dict[str, dict[str, float]] = {
        "speed-ekf": speed,
        "ekf": {**speed, **flow},
        "nlo": {**speed, **linear, **cubic, "printed": int(not as_run)},
        "kfnlo": {**speed, **flow, **cubic, **(linear if as_run else {}), "printed": int(not as_run)},
    }
    return checked(OBSERVERS[observer](**chosen[observer]))
