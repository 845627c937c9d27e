"""What the propeller's simulator may hide: effects of the library with their sizes, and others of no library."""

__all__ = ["BEYOND", "ROWS", "TABLE", "TOGETHER"]

# One row each: effect, parameter, range of sizes, whether either sign counts; further parameters beside it.
TABLE: tuple[tuple[str, str, float, float, bool, tuple[tuple[str, float, float], ...]], ...] = (
    ("command_delay", "time", 0.025, 0.22, False, ()),
    ("command_lag", "time", 0.025, 0.35, False, ()),
    ("throttle_rate_limit", "rate", 2.5, 35.0, False, ()),
    ("throttle_saturation", "limit", 1.5, 3.0, False, ()),
    ("command_quantization", "step", 0.12, 0.5, False, ()),
    ("dead_zone_shift", "voltage", 0.07, 0.4, True, ()),
    ("throttle_gain", "share", 0.09, 0.5, True, ()),
    ("supply_sag", "share", 0.08, 0.5, False, ()),
    ("thermal_fade", "share", 0.12, 0.5, False, (("time_constant", 5.0, 50.0),)),
    ("coulomb_friction", "deceleration", 50.0, 450.0, False, ()),
    ("viscous_friction", "share", 0.15, 0.8, True, ()),
    ("rotor_inertia", "share", 0.2, 1.4, False, ()),
    ("start_hysteresis", "voltage", 0.1, 0.5, False, ()),
    ("thrust_loss", "share", 0.15, 0.9, False, ()),
    ("thrust_asymmetry", "share", 0.08, 0.5, True, ()),
    ("propeller_fouling", "share", 0.15, 0.6, False, ()),
    ("entrained_water", "impulse", 0.003, 0.02, False, ()),
    ("cavitation", "share", 0.2, 1.0, False, (("onset", 45.0, 80.0),)),
    ("ambient_current", "speed", 0.04, 0.3, True, ()),
    ("flow_lag", "share", 0.5, 3.5, False, ()),
    ("tach_lag", "time", 0.025, 0.35, False, ()),
    ("tach_scale", "share", 0.1, 0.3, True, ()),
    ("tach_quantization", "step", 3.5, 20.0, False, ()),
    ("flow_delay", "time", 0.12, 1.4, False, ()),
    ("flow_bias", "offset", 0.012, 0.2, True, ()),
    ("load_cell_scale", "share", 0.1, 0.3, True, ()),
    ("load_cell_bias", "offset", 0.4, 5.0, True, ()),
    ("load_cell_drift", "rate", 0.015, 0.1, True, ()),
    ("load_cell_resonance", "frequency", 1.5, 14.0, False, (("damping", 0.02, 0.5),)),
    ("log_alignment", "*", 0.015, 0.12, True, ()),
    ("clock_drift", "rate", 1.5e-3, 1e-2, True, ()),
)
ROWS = {row[0]: row for row in TABLE}
TOGETHER = [row[0] for row in TABLE if row[0] not in (
    "throttle_rate_limit", "throttle_saturation", "command_quantization", "cavitation", "tach_quantization",
    "load_cell_resonance", "log_alignment", "clock_drift", "throttle_lag", "load_cell_scale", "propeller_fouling",
)]  # fmt: skip
BEYOND: dict[str, tuple[str, float, float]] = {
    "another_class": ("blades", 1.0, 1.0),
    "soft_coupling": ("frequency", 1.2, 4.0),  # [Hz] the propeller turns behind the motor on a springy shaft
    "sloshing": ("gain", 0.006, 0.018),  # [m/s^2/N] of the water at 0.25 Hz
    "speed_limit": ("speed", 45.0, 75.0),  # [rad/s] above which a governor takes the drive away
    "loose_plug": ("share", 0.25, 0.7),  # of the drive lost in single stretches of some seconds
    "thrust_by_history": ("share", 0.2, 0.5),  # of the thrust lost as the last 3 s were spent at high speed
}
