r"""Extended Kalman filter of the rotor speed n, one state (thesis 4.3, with the simplified model in 5.1).

State n [rad/s]; inputs u, the acting throttle [V], and v, the axial flow [m/s], which is 0 in the simplified model.

(3.8)         dn/dt = f(n) = -k_n n - k_Q Q(n, v) + gamma(u) + w,   E[w(t) w(s)] = q delta(t - s),  q [rad^2/s^3]
signed        z = n + e,       H = 1,        E[e^2] = r [rad^2/s^2]
unsigned      z = |n| + e,     H = sgn n̂

prediction    a = df/dn;   n̂ += f(n̂) (e^{ah} - 1) / a,   P = e^{2ah} P + q (e^{2ah} - 1) / (2a),   in sub-steps h
innovation    y = z - n̂ (unsigned: y = sgn(n̂) z - n̂),   S = P + r,   NIS = y^2 / S
correction    K = P / S;   n̂ += K y,   P = (1 - K)^2 P + K^2 r

An unsigned tachometer cannot tell n from -n. Where |n̂| is within its own standard deviation of zero, r is raised by
the mean square that a wrong sign adds under the belief, E[(sgn(n̂)|n| - n)^2]: 2 P at n̂ = 0, 0.3 P at |n̂| = sqrt(P).
Farther out the sign of the belief is trusted: a confident belief with the wrong sign is not found by this filter.
"""

from dataclasses import dataclass, replace
from enum import Enum
from math import ceil, copysign, erfc, exp, expm1, inf, isfinite, pi, sqrt
from statistics import NormalDist
from typing import NamedTuple

from thruster_model.equations.thruster import ThrusterCoefficients, input_map, rotor_acceleration, torque

__all__ = [
    "Innovation", "Settings", "SpeedBelief", "Status", "Step", "Validity", "acceleration", "correct", "gated",
    "innovation_of", "jacobian", "measurement_fault", "nis_interval", "predict", "step", "validity",
]  # fmt: skip


class Status(Enum):
    """What the last step did with the measurement."""

    INITIAL = "initial"
    UPDATED = "updated"
    AMBIGUOUS = "ambiguous"
    """Updated with a raised r: unsigned tachometer, sign of the speed in doubt."""
    PREDICTED = "predicted"
    """No usable measurement."""
    GATED = "gated"


@dataclass(frozen=True, kw_only=True)
class SpeedBelief:
    """Estimated rotor speed [rad/s], its standard deviation [rad/s], and how it came about.

    `unseen` is the time [s] since the last measurement that was used.
    """

    n: float
    deviation: float
    status: Status = Status.INITIAL
    reason: str = "no step taken yet"
    unseen: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.n) and isfinite(self.deviation) and self.deviation >= 0):
            raise ValueError(f"belief: expected finite n and deviation >= 0, got {self.n} and {self.deviation} rad/s")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What the filter assumes.

    Attributes:
        coefficients: of the rotor, `ParameterSet.coefficients`.
        q: density of the process noise [rad^2/s^3].
        r: variance of the measurement noise [rad^2/s^2].
        unsigned: the tachometer measures |n|.
        gate: largest NIS that is used; 10.83 is passed by 99.9 % of consistent innovations, inf by all.
        largest_step: upper bound of the prediction's sub-steps [s].
    """

    coefficients: ThrusterCoefficients
    q: float
    r: float
    unsigned: bool = False
    gate: float = inf
    largest_step: float = 1e-3

    def __post_init__(self) -> None:
        wrong = [
            f"{name} = {getattr(self, name)}" for name in ("r", "gate", "largest_step") if not getattr(self, name) > 0
        ]
        wrong += [f"{name} = {getattr(self, name)}" for name in ("r", "largest_step") if not getattr(self, name) < inf]
        wrong += [] if 0 <= self.q < inf else [f"q = {self.q}"]
        if wrong:
            raise ValueError(f"settings: expected r, gate, largest_step > 0 and q >= 0, finite; got {', '.join(wrong)}")


class Innovation(NamedTuple):
    """Measured less predicted speed [rad/s], its variance S and the measurement's r [rad^2/s^2]."""

    y: float
    S: float
    r: float
    ambiguous: bool = False

    @property
    def nis(self) -> float:
        """Innovation squared over its variance; of a consistent filter chi-square with one degree of freedom."""
        return self.y * self.y / self.S


class Step(NamedTuple):
    """The belief after a step and the innovation of its measurement, None where there was none."""

    belief: SpeedBelief
    innovation: Innovation | None


class Validity(NamedTuple):
    """Whether a belief may be used, and why not."""

    valid: bool
    reason: str


def acceleration(n: float, u: float, v: float, p: ThrusterCoefficients) -> float:
    """Return f(n) of (3.8) [rad/s^2]."""
    return float(rotor_acceleration(n, torque(n, v, p), input_map(u, p), p))


def jacobian(n: float, v: float, p: ThrusterCoefficients) -> float:
    """Return a = df/dn [1/s]; at the edges of the torque's dead zone the value inside it."""
    square = n * abs(n)
    slope = p.c_Q1 if square < p.delta_Q1 else p.c_Q2 if square > p.delta_Q2 else 0.0
    torque_slope = 2.0 * abs(n) * slope - p.c_nv_Q * _sign(n) * v
    return -p.k_n - 2.0 * p.k_2 * abs(n) - p.k_Q * torque_slope


def predict(belief: SpeedBelief, dt: float, u: float, settings: Settings, v: float = 0.0) -> SpeedBelief:
    """Return the belief after `dt` [s] under the acting throttle u [V] and the axial flow v [m/s], both held."""
    if not (isfinite(dt) and dt >= 0 and isfinite(u) and isfinite(v)):
        raise ValueError(f"predict: expected finite dt >= 0, u and v, got {dt} s, {u} V and {v} m/s")
    # Python's floats: NumPy's scalars, which callers hand in, would make each sub-step several times slower.
    p, n, P = settings.coefficients, float(belief.n), float(belief.deviation) ** 2
    dt, u, v = float(dt), float(u), float(v)
    count = ceil(dt / settings.largest_step - 1e-9)
    h = dt / max(count, 1)
    for _ in range(count):
        a = jacobian(n, v, p)
        n += h * _phi(a * h) * acceleration(n, u, v, p)
        a = 0.5 * (a + jacobian(n, v, p))
        P = exp(2.0 * a * h) * P + settings.q * h * _phi(2.0 * a * h)
    return SpeedBelief(
        n=n, deviation=sqrt(P), status=Status.PREDICTED, reason="no measurement", unseen=belief.unseen + dt
    )


def measurement_fault(n_measured: float | None, unsigned: bool) -> str:
    """Return why a measurement [rad/s] cannot be used, empty where it can."""
    if n_measured is None:
        return "measurement missing"
    if not isfinite(n_measured):
        return f"measurement is {n_measured}"
    if unsigned and n_measured < 0:
        return f"unsigned tachometer gave {n_measured:g} rad/s"
    return ""


def innovation_of(belief: SpeedBelief, n_measured: float, settings: Settings) -> Innovation:
    """Return the innovation of a usable measurement [rad/s] against a predicted belief."""
    n, P, r, n_measured = belief.n, belief.deviation**2, settings.r, float(n_measured)
    if not settings.unsigned:
        return Innovation(n_measured - n, P + r, r)
    ambiguous = abs(n) < belief.deviation
    if ambiguous:
        r += _wrong_sign(n, belief.deviation)
    return Innovation(copysign(1.0, n) * n_measured - n, P + r, r, ambiguous)


def gated(innovation: Innovation, threshold: float) -> bool:
    """Return whether the innovation is too unlikely to be used: NIS > threshold."""
    return innovation.nis > threshold


def correct(belief: SpeedBelief, innovation: Innovation) -> SpeedBelief:
    """Return the belief corrected by the innovation; the variance in Joseph's form."""
    P = belief.deviation**2
    K = P / innovation.S
    P = (1.0 - K) ** 2 * P + K**2 * innovation.r
    status, reason = Status.UPDATED, "measurement used"
    if innovation.ambiguous:
        status, reason = Status.AMBIGUOUS, "unsigned measurement used with raised r: speed within its deviation of zero"
    return SpeedBelief(n=belief.n + K * innovation.y, deviation=sqrt(P), status=status, reason=reason)


def step(
    belief: SpeedBelief, n_measured: float | None, dt: float, *, u: float, settings: Settings, v: float = 0.0
) -> Step:
    """Predict over `dt` [s], then take in the measurement [rad/s] made at its end, None or NaN where there is none."""
    predicted = predict(belief, dt, u, settings, v)
    fault = measurement_fault(n_measured, settings.unsigned)
    if fault or n_measured is None:
        return Step(replace(predicted, reason=fault), None)
    innovation = innovation_of(predicted, n_measured, settings)
    if gated(innovation, settings.gate):
        reason = f"NIS {innovation.nis:.3g} > {settings.gate:g}"
        return Step(replace(predicted, status=Status.GATED, reason=reason), innovation)
    return Step(correct(predicted, innovation), innovation)


def validity(belief: SpeedBelief, largest_deviation: float, longest_unseen: float) -> Validity:
    """Return whether the belief is as sharp [rad/s] and as fresh [s] as asked for; a shut gate shows in the latter."""
    wrong = []
    if belief.deviation > largest_deviation:
        wrong.append(f"deviation {belief.deviation:.3g} > {largest_deviation:g} rad/s")
    if belief.unseen > longest_unseen:
        wrong.append(f"no measurement used for {belief.unseen:.3g} > {longest_unseen:g} s, last: {belief.reason}")
    return Validity(not wrong, "; ".join(wrong) or "deviation and age within bounds")


def nis_interval(count: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the two-sided interval of the mean of `count` >= 10 NIS values, by Wilson and Hilferty to 1 %."""
    if not (count >= 10 and 0 < confidence < 1):
        raise ValueError(f"nis_interval: expected count >= 10 and 0 < confidence < 1, got {count} and {confidence}")
    c, z = 2.0 / (9.0 * count), NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    return (1.0 - c - z * sqrt(c)) ** 3, (1.0 - c + z * sqrt(c)) ** 3


def _sign(x: float) -> float:
    return copysign(1.0, x) if x != 0 else 0.0


def _phi(x: float) -> float:
    """Return (e^x - 1) / x, 1 at x = 0."""
    return expm1(x) / x if x != 0.0 else 1.0


def _wrong_sign(n: float, deviation: float) -> float:
    """Return E[(sgn(n̂)|n| - n)^2] = 4 E[n^2; sgn n != sgn n̂] for n ~ N(n̂, deviation^2) [rad^2/s^2]."""
    m = abs(n) / deviation
    tail, density = 0.5 * erfc(m / sqrt(2.0)), exp(-0.5 * m * m) / sqrt(2.0 * pi)
    return 4.0 * deviation**2 * ((1.0 + m * m) * tail - m * density)
