"""The effects that the blind check plays with: where each enters, its sizes, and in which models it does nothing."""

from dataclasses import dataclass

__all__ = ["EFFECTS", "OUTSIDE", "Kind", "Spread", "acting_in"]


@dataclass(frozen=True, kw_only=True)
class Spread:
    """How one parameter of an effect is drawn.

    Attributes:
        name: as in the library of effects.
        lower, upper: range, in the effect's unit.
        signed: either sign counts.
        law: "log" for log-uniform, "uniform".
        most_negative: largest magnitude with a negative sign where that differs from `upper`.
        falls: a smaller value is a stronger effect (limits, time scales of a mode).
    """

    name: str
    lower: float
    upper: float
    signed: bool = False
    law: str = "log"
    most_negative: float | None = None
    falls: bool = False


@dataclass(frozen=True, kw_only=True)
class Kind:
    """One effect: block, size first and further parameters after it, models that do not feel it, exact twins."""

    block: str
    size: Spread
    more: tuple[Spread, ...] = ()
    inert_in: tuple[str, ...] = ()
    twins: tuple[str, ...] = ()
    structural: bool = True


_LEAST = 0.15  # of the plausible maximum


def _upto(
    name: str, largest: float, *, signed: bool = False, least: float = _LEAST, negative: float | None = None
) -> Spread:
    return Spread(name=name, lower=least * largest, upper=largest, signed=signed, most_negative=negative)


def _also(name: str, lower: float, upper: float, law: str = "uniform") -> Spread:
    return Spread(name=name, lower=lower, upper=upper, law=law)


_SIMPLE = ("simplified",)
_SHIFTS = ("command_delay", "flow_delay")

EFFECTS: dict[str, Kind] = {
    "log_alignment": Kind(block="log", size=_upto("", 0.12, signed=True), twins=_SHIFTS),
    "clock_drift": Kind(block="log", size=_upto("rate", 1e-2, signed=True)),
    "timestamp_jitter": Kind(block="log", size=_upto("deviation", 0.03)),
    "dropped_samples": Kind(block="log", size=_upto("share", 0.5)),
    "command_delay": Kind(block="command", size=_upto("time", 0.25), twins=("log_alignment",)),
    "command_lag": Kind(block="command", size=_upto("time", 0.4), more=(_also("unevenness", 0.02, 0.2),)),
    "command_quantization": Kind(block="command", size=_upto("step", 0.5)),
    "throttle_rate_limit": Kind(block="command", size=Spread(name="rate", lower=2.0, upper=60.0, falls=True)),
    "throttle_saturation": Kind(
        block="command", size=Spread(name="limit", lower=1.0, upper=3.4, law="uniform", falls=True)
    ),
    "dead_zone_shift": Kind(block="command", size=_upto("voltage", 0.4, signed=True), structural=False),
    "throttle_gain": Kind(block="command", size=_upto("share", 0.5, signed=True), structural=False),
    "supply_sag": Kind(block="command", size=_upto("share", 0.5)),
    "thermal_fade": Kind(block="command", size=_upto("share", 0.5), more=(_also("time_constant", 5.0, 200.0),)),
    "thruster_polarity": Kind(block="command", size=Spread(name="reversed", lower=1.0, upper=1.0, law="uniform")),
    "coulomb_friction": Kind(block="rotor", size=_upto("deceleration", 500.0)),
    "viscous_friction": Kind(block="rotor", size=_upto("share", 0.8, signed=True), structural=False),
    "rotor_inertia": Kind(block="rotor", size=_upto("share", 1.5, signed=True, negative=0.5), structural=False),
    "brake_asymmetry": Kind(
        block="rotor", size=_upto("share", 0.8, signed=True), more=(_also("onset", 0.05, 1.0, "log"),)
    ),
    "start_hysteresis": Kind(block="rotor", size=_upto("voltage", 0.5)),
    "propeller_fouling": Kind(block="rotor", size=_upto("share", 0.6), structural=False),
    "thrust_loss": Kind(block="thrust", size=_upto("share", 1.0, signed=True, negative=0.3), structural=False),
    "thrust_asymmetry": Kind(block="thrust", size=_upto("share", 0.5, signed=True)),
    "axial_flow_loss": Kind(block="thrust", size=_upto("share", 1.5), inert_in=_SIMPLE, structural=False),
    "quadratic_flow_loss": Kind(block="thrust", size=_upto("coefficient", 400.0), inert_in=_SIMPLE),
    "flow_reversal_loss": Kind(block="thrust", size=_upto("share", 0.9), inert_in=_SIMPLE),
    "entrained_water": Kind(block="thrust", size=_upto("impulse", 0.02)),
    "oblique_inflow": Kind(block="thrust", size=_upto("angle", 1.2), inert_in=_SIMPLE),
    "ventilation": Kind(block="thrust", size=_upto("share", 0.8), more=(_also("onset", 20.0, 110.0),)),
    "cavitation": Kind(block="thrust", size=_upto("share", 1.0), more=(_also("onset", 40.0, 110.0),)),
    "water_unloaded": Kind(block="thrust", size=_upto("share", 1.0), structural=False),
    "ambient_current": Kind(block="flow", size=_upto("speed", 0.3, signed=True), inert_in=_SIMPLE),
    "tank_recirculation": Kind(
        block="flow", size=_upto("share", 0.9), more=(_also("delay", 1.0, 10.0),), inert_in=_SIMPLE
    ),
    "flow_lag": Kind(
        block="flow", size=_upto("share", 4.0, signed=True, negative=0.5), inert_in=_SIMPLE, structural=False
    ),
    "tach_lag": Kind(block="sensor", size=_upto("time", 0.4)),
    "tach_scale": Kind(block="sensor", size=_upto("share", 0.3, signed=True), structural=False),
    "tach_quantization": Kind(block="sensor", size=_upto("step", 20.0)),
    "tach_dropout": Kind(block="sensor", size=_upto("threshold", 40.0)),
    "flow_scale": Kind(block="sensor", size=_upto("share", 0.3, signed=True), inert_in=_SIMPLE, structural=False),
    "flow_bias": Kind(block="sensor", size=_upto("offset", 0.2, signed=True), inert_in=_SIMPLE),
    "flow_delay": Kind(block="sensor", size=_upto("time", 1.5), inert_in=_SIMPLE, twins=("log_alignment",)),
    "flow_spikes": Kind(block="sensor", size=_upto("share", 0.3)),
    "load_cell_scale": Kind(block="sensor", size=_upto("share", 0.3, signed=True), structural=False),
    "load_cell_bias": Kind(block="sensor", size=_upto("offset", 5.0, signed=True)),
    "load_cell_drift": Kind(block="sensor", size=_upto("rate", 0.1, signed=True)),
    "load_cell_crosstalk": Kind(block="sensor", size=_upto("gain", 30.0, signed=True)),
    "load_cell_resonance": Kind(
        block="sensor",
        size=Spread(name="frequency", lower=1.0, upper=30.0, falls=True),
        more=(_also("damping", 0.01, 0.7, "log"),),
    ),
}
"""The library's effects on one thruster. The channel of `log_alignment` is drawn: throttle, speed, flow or load."""

OUTSIDE: dict[str, Kind] = {
    "throttle_backlash": Kind(block="command", size=_upto("width", 0.8, least=0.4)),
    "throttle_cubic": Kind(block="command", size=_upto("curvature", 0.05, least=0.4)),
    "drive_resonance": Kind(
        block="command",
        size=_upto("share", 0.9, least=0.4),
        more=(_also("frequency", 0.5, 1.5, "log"), _also("damping", 0.03, 0.3, "log")),
    ),
    "gain_step": Kind(block="command", size=_upto("share", 0.5, least=0.3), more=(_also("time", 8.0, 22.0),)),
    "static_friction_peak": Kind(block="rotor", size=_upto("deceleration", 700.0, least=0.5)),
    "growing_ripple": Kind(
        block="rotor", size=_upto("deceleration", 600.0, least=0.4), more=(_also("frequency", 0.5, 2.0),)
    ),
    "low_speed_exponent": Kind(block="thrust", size=_upto("exponent", 2.0, least=0.4)),
    "wake_stall": Kind(block="thrust", size=_upto("share", 0.8, least=0.4)),
    "torque_by_current": Kind(block="thrust", size=_upto("share", 0.5, least=0.4), inert_in=_SIMPLE),
    "tank_seiche": Kind(
        block="flow",
        size=_upto("gain", 0.02, least=0.4),
        more=(_also("frequency", 0.1, 0.3), _also("damping", 0.03, 0.3, "log")),
        inert_in=_SIMPLE,
    ),
    "load_cell_creep": Kind(block="sensor", size=_upto("share", 0.5, least=0.4), more=(_also("time", 1.0, 5.0),)),
    "tach_periodic_error": Kind(
        block="sensor", size=_upto("amplitude", 8.0, least=0.5), more=(_also("period", 3.0, 12.0, "log"),)
    ),
    "flow_compression": Kind(block="sensor", size=_upto("curvature", 8.0, least=0.4), inert_in=_SIMPLE),
    "clock_jump": Kind(block="log", size=_upto("time", 0.4, signed=True, least=0.4), more=(_also("when", 0.2, 0.8),)),
}
"""Effects that are in no library, to see what is said about the unknown; ids of our own, blocks as in the library."""


def acting_in(model: str, table: dict[str, Kind]) -> tuple[str, ...]:
    """Return the effects of a table that do something in a model."""
    return tuple(name for name, kind in table.items() if model not in kind.inert_in)
