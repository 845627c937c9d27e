"""Recordings of a simulator with other conventions than the bench's: what these leave open is no effect.

The HL model once more, by Runge-Kutta with the command held and its ramp in stairs, at other rates, under noise with
heavy tails. None of this is the diagnosis' or the blind check's.
"""

import numpy as np
import pytest

from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.preparing import recording_of
from thruster_model.compilation import compiled
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
LONG = pytest.mark.long
NAMES = (
    "c_u1", "c_u2", "delta_u1", "delta_u2", "k_n", "k_Q", "c_n_T", "c_nv_T", "c_n_Q", "c_nv_Q",
    "k_v", "k_Uv", "k_w", "k_Tv", "k_U", "k_UU", "k_TU",
)  # fmt: skip
NOISE = {"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4}
RAMP = 100.0  # [V/s]


@compiled
def rates(x, u, p, loss, brake):  # type: ignore[no-untyped-def]
    n, v, flow = x
    drive = p[0] * (u - p[2]) if u <= p[2] else p[1] * (u - p[3]) if u >= p[3] else 0.0
    thrust = (1.0 - loss) * (p[6] * n * abs(n) - p[7] * abs(n) * v)
    torque = p[8] * n * abs(n) - p[9] * abs(n) * v
    dn = -p[4] * n - p[5] * torque + drive
    if dn * n < 0.0:  # another friction while |n| falls; a rotor that it would not let fall stays
        dn = min(dn - brake * p[4] * n, 0.0) if n > 0.0 else max(dn - brake * p[4] * n, 0.0)
    dv = -p[10] * v - p[11] * abs(v) * (v - p[12] * flow) + p[13] * thrust
    return np.array([dn, dv, -p[14] * flow - p[15] * flow * abs(flow) + p[16] * thrust]), thrust, torque


@compiled
def run_of(commands, p, period, substeps, lag, loss, brake):  # type: ignore[no-untyped-def]
    """Return (N, 4): speed, flow, thrust, torque before each command acts."""
    step, x, u, wanted = period / substeps, np.zeros(3), 0.0, 0.0
    read = np.zeros((commands.size, 4))
    for k in range(commands.size):
        _, thrust, torque = rates(x, u, p, loss, brake)
        read[k] = np.array([x[0], x[2], thrust, torque])
        for _ in range(substeps):
            wanted += (commands[k] - wanted) * (1.0 - np.exp(-step / lag) if lag > 0.0 else 1.0)
            u += min(max(wanted - u, -RAMP * step), RAMP * step)
            a = rates(x, u, p, loss, brake)[0]
            b = rates(x + 0.5 * step * a, u, p, loss, brake)[0]
            c = rates(x + 0.5 * step * b, u, p, loss, brake)[0]
            d = rates(x + step * c, u, p, loss, brake)[0]
            x = x + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return read


def recordings(
    rate,
    step,
    seed,
    *,
    tails,
    lag=0.0,
    loss=0.0,
    brake=0.0,
    scatter=0.0,
    coarse=0.0,
    duration=25.0,
    clocks=0.0,
    early=0.0,
):
    """Return random steps, a chirp and a staircase as recorded at `rate` [Hz] by a simulator with this `step` [s].

    `scatter`: of the instants of the readings about their stamps [s]; `coarse`: step [rad/s] of the tachometer, to
    which noise is added; `clocks`: by which each topic's clock is off in a run [s], at random; `early`: most periods by
    which a command acts, and is stamped, before its turn.
    """
    rng, timing = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    p = np.array([HL.values[name] * (1.0 + 0.05 * rng.uniform(-1.7, 1.7)) for name in NAMES])
    period = 1.0 / rate
    at: np.ndarray = period * np.arange(round(duration * rate))
    levels = rng.uniform(-4.5, 4.5, 100)
    programmes = {
        "steps": levels[np.searchsorted(np.cumsum(rng.uniform(0.4, 3.0, 100)), at)],
        "chirp": 3.5 * np.sin(2.0 * np.pi * (0.05 * at + 0.5 * 1.45 / duration * at**2)),
        "stairs": np.array([0.0, 1.2, 2.2, 3.2, 4.2, 0.0, -1.2, -2.2, -3.2, -4.2])[(at / duration * 10).astype(int)],
    }
    found = []
    for name, commands in programmes.items():
        sent = at - early * period * timing.uniform(0.0, 1.0, at.size)
        sent[0] = 0.0
        late = clocks * timing.standard_normal(3)[[0, 1, 2, 2]]
        if scatter > 0.0 or clocks > 0.0:
            finely = period / 32 * np.arange(32 * at.size)
            acting = commands[np.searchsorted(sent, finely + 1e-9, side="right") - 1]
            fine: np.ndarray = run_of(acting, p, period / 32, max(round(period / step / 32), 1), lag, loss, brake)
            when = at[:, None] - late + scatter * rng.standard_normal((at.size, 4))
            clean = np.column_stack([np.interp(when[:, k], finely, fine[:, k]) for k in range(4)])
        else:
            clean = run_of(commands, p, period, max(round(period / step), 1), lag, loss, brake)
        if coarse > 0.0:
            clean[:, 0] = coarse * np.round(clean[:, 0] / coarse)
        shocks = rng.standard_t(4, clean.shape) / np.sqrt(2.0) if tails else rng.standard_normal(clean.shape)
        read = clean + np.array(list(NOISE.values())) * shocks
        found.append(recording_of(name, (sent, commands), {s: (at, read[:, k]) for k, s in enumerate(NOISE)}))
    return found


@pytest.mark.parametrize(
    ("rate", "step", "tails", "more"),
    [
        (25.0, 1e-3, True, {"clocks": 3e-3, "early": 0.5, "duration": 15.0}),
        pytest.param(50.0, 1e-3, True, {}, marks=LONG),
        pytest.param(60.0, 2e-3, False, {}, marks=LONG),
        pytest.param(25.0, 5e-3, False, {}, marks=LONG),
        pytest.param(100.0, 5e-3, True, {}, marks=LONG),
    ],
)
def test_half_a_step_heavy_tails_and_clocks_are_no_effect(rate, step, tails, more):
    verdict = diagnose(recordings(rate, step, 7, tails=tails, **more), HL).verdict
    assert (verdict.verdict, verdict.claims) == ("parameters", ())


@pytest.mark.parametrize(
    ("rate", "step", "effect", "truth", "parameter", "size"),
    [
        pytest.param(50.0, 1e-3, "command_lag", {"lag": 0.08, "duration": 15.0}, "time", 0.08, marks=LONG),
        pytest.param(20.0, 2e-3, "thrust_loss", {"loss": 0.35}, "share", 0.35, marks=LONG),
        pytest.param(25.0, 5e-4, "brake_asymmetry", {"brake": 0.4}, "share", 0.4, marks=LONG),
        pytest.param(50.0, 5e-4, "brake_asymmetry", {"brake": -0.3}, "share", -0.3, marks=LONG),
        pytest.param(25.0, 5e-4, "timestamp_jitter", {"scatter": 0.012}, "deviation", 0.012, marks=LONG),
        (25.0, 1e-3, "tach_quantization", {"coarse": 4.0, "duration": 15.0}, "step", 4.0),
    ],
)
def test_effects_are_named_in_the_same_recordings(rate, step, effect, truth, parameter, size):
    (claim,) = diagnose(recordings(rate, step, 8, tails=True, **truth), HL).verdict.claims
    assert claim.effect == effect
    assert abs(claim.sizes[parameter].value - size) < 4.0 * claim.sizes[parameter].std
