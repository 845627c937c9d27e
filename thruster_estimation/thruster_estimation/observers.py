"""One step function for all observers: the class of the settings chooses the observer, when a kernel is compiled."""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from thruster_estimation.ekf import ekf_step, kfnlo_step
from thruster_estimation.nlo import nlo_step
from thruster_estimation.settings import EkfSettings, KfnloSettings, NloSettings, SpeedEkfSettings
from thruster_estimation.speed_ekf import speed_ekf_step

__all__ = ["observer_step"]

_STEPS: dict[type, Callable[..., Any]] = {
    EkfSettings: ekf_step,
    NloSettings: nlo_step,
    KfnloSettings: kfnlo_step,
    SpeedEkfSettings: speed_ekf_step,
}


def observer_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) after one period, from Python or from a kernel.

    In the proper form: predicted over `dt` under the throttle u that acted in it, then corrected with what was
    measured at its end. In the bench's form y and u are those of the period's beginning: see `bench_form`.

    Args:
        belief: `Belief` at the beginning.
        y_n: measured rotor speed [rad/s], NaN: none.
        y_U: measured ambient flow [m/s], NaN: none.
        dt: period [s]; not finite or negative: nothing is predicted, status BAD_PERIOD.
        u: throttle that acted [V]; NaN: not known, n is held and its deviation widened, status NO_THROTTLE.
        settings: one of the classes of `settings`.
        p: `ThrusterCoefficients`: simplified, HL or HQ.
    """
    return _STEPS[type(settings)](belief, y_n, y_U, dt, u, settings, p)


@overload(observer_step, inline="always")
def _compile_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    chosen = _STEPS[settings.instance_class]
    return lambda belief, y_n, y_U, dt, u, settings, p: chosen(belief, y_n, y_U, dt, u, settings, p)
