"""What the laboratory's simulator may hide: effects of the library with their sizes, and others of no library."""

__all__ = ["EFFECTS", "IN_PLANT", "MORE", "OUTSIDE", "SMALL"]

# effect -> (parameter, smallest, largest size that is drawn, either sign)
EFFECTS: dict[str, tuple[str, float, float, bool]] = {
    "log_alignment": ("", 0.012, 0.1, True),
    "clock_drift": ("rate", 1e-3, 8e-3, True),
    "timestamp_jitter": ("deviation", 0.004, 0.025, False),
    "dropped_samples": ("share", 0.06, 0.4, False),
    "command_delay": ("time", 0.02, 0.2, False),
    "command_lag": ("time", 0.02, 0.3, False),
    "command_quantization": ("step", 0.1, 0.5, False),
    "throttle_rate_limit": ("rate", 3.0, 40.0, False),
    "throttle_saturation": ("limit", 1.6, 3.2, False),
    "dead_zone_shift": ("voltage", 0.06, 0.4, True),
    "throttle_gain": ("share", 0.08, 0.45, True),
    "supply_sag": ("share", 0.06, 0.45, False),
    "thermal_fade": ("share", 0.1, 0.5, False),
    "coulomb_friction": ("deceleration", 40.0, 450.0, False),
    "viscous_friction": ("share", 0.12, 0.7, True),
    "rotor_inertia": ("share", 0.15, 1.2, False),
    "brake_asymmetry": ("share", 0.15, 0.7, True),
    "start_hysteresis": ("voltage", 0.08, 0.45, False),
    "propeller_fouling": ("share", 0.12, 0.5, False),
    "thrust_loss": ("share", 0.15, 0.8, False),
    "thrust_asymmetry": ("share", 0.06, 0.45, True),
    "axial_flow_loss": ("share", 0.2, 1.4, False),
    "quadratic_flow_loss": ("coefficient", 40.0, 350.0, False),
    "flow_reversal_loss": ("share", 0.15, 0.85, False),
    "entrained_water": ("impulse", 0.002, 0.018, False),
    "cavitation": ("share", 0.15, 0.9, False),
    "ambient_current": ("speed", 0.03, 0.25, True),
    "tank_recirculation": ("share", 0.15, 0.8, False),
    "flow_lag": ("share", 0.4, 3.0, False),
    "tach_lag": ("time", 0.02, 0.3, False),
    "tach_scale": ("share", 0.1, 0.28, True),
    "tach_quantization": ("step", 3.0, 18.0, False),
    "tach_dropout": ("threshold", 8.0, 38.0, False),
    "flow_scale": ("share", 0.1, 0.28, True),
    "flow_bias": ("offset", 0.01, 0.15, True),
    "flow_delay": ("time", 0.1, 1.2, False),
    "flow_spikes": ("share", 0.03, 0.25, False),
    "load_cell_scale": ("share", 0.1, 0.28, True),
    "load_cell_bias": ("offset", 0.4, 4.0, True),
    "load_cell_drift": ("rate", 0.012, 0.09, True),
    "load_cell_crosstalk": ("gain", 20.0, 30.0, True),
    "load_cell_resonance": ("frequency", 1.5, 12.0, False),
}
MORE = {
    "thermal_fade": ("time_constant", 6.0, 60.0),
    "cavitation": ("onset", 45.0, 85.0),
    "tank_recirculation": ("delay", 1.5, 6.0),
    "load_cell_resonance": ("damping", 0.02, 0.4),
    "brake_asymmetry": ("onset", 0.3, 1.0),
}
SMALL = (
    "throttle_gain", "dead_zone_shift", "coulomb_friction", "command_lag", "command_delay", "thrust_loss",
    "thrust_asymmetry", "viscous_friction", "supply_sag", "start_hysteresis", "flow_bias", "flow_lag", "tach_lag",
    "load_cell_bias", "entrained_water", "ambient_current", "flow_delay", "brake_asymmetry",
)  # fmt: skip
"""Effects of which several small ones are drawn together."""
OUTSIDE: dict[str, tuple[str, float, float]] = {
    "wake_memory": ("share", 0.25, 0.6),  # a share of the thrust builds up within 0.4 s
    "drifting_dead_zone": ("rate", 0.012, 0.03),  # [V/s] by which the upper edge moves outwards
    "cogging": ("deceleration", 150.0, 500.0),  # [rad/s^2] at the rotor's angle, fading above 25 rad/s
    "quadratic_command": ("curvature", 0.04, 0.1),  # [1/V] u + s u|u| - s u^2 / 2
    "flow_meter_wall": ("share", 0.4, 0.9),  # U is read too small by share x U / 0.3 m/s
    "weakened_reverse": ("seconds", 0.3, 1.2),  # for so long after a reversal the drive has half its gain
}


IN_PLANT = {
    ("command_delay", "time"): "delay", ("command_lag", "time"): "lag", ("command_quantization", "step"): "round_to",
    ("throttle_rate_limit", "rate"): "slew", ("throttle_saturation", "limit"): "limit",
    ("dead_zone_shift", "voltage"): "edge", ("throttle_gain", "share"): "gain", ("supply_sag", "share"): "sag",
    ("thermal_fade", "share"): "fade", ("thermal_fade", "time_constant"): "fade_time",
    ("coulomb_friction", "deceleration"): "dry", ("viscous_friction", "share"): "viscous",
    ("rotor_inertia", "share"): "inertia", ("brake_asymmetry", "share"): "brake",
    ("brake_asymmetry", "onset"): "brake_onset", ("start_hysteresis", "voltage"): "hysteresis",
    ("propeller_fouling", "share"): "fouling", ("thrust_loss", "share"): "loss",
    ("thrust_asymmetry", "share"): "reverse_loss", ("axial_flow_loss", "share"): "axial",
    ("quadratic_flow_loss", "coefficient"): "quadratic", ("flow_reversal_loss", "share"): "against",
    ("entrained_water", "impulse"): "impulse", ("cavitation", "share"): "vapour",
    ("cavitation", "onset"): "vapour_from", ("ambient_current", "speed"): "current",
    ("tank_recirculation", "share"): "again", ("tank_recirculation", "delay"): "again_after",
    ("flow_lag", "share"): "slow_flow", ("wake_memory", "share"): "wake",
    ("drifting_dead_zone", "rate"): "edge_drift", ("cogging", "deceleration"): "cogging",
    ("quadratic_command", "curvature"): "curvature", ("weakened_reverse", "seconds"): "half_gain",
}  # fmt: skip
