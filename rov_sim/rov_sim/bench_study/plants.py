"""The true thruster of an experiment: a parameter set whose values are off by factors drawn within its deviations."""

from math import exp

import numpy as np

from rov_sim.closed_loop import Plant
from thruster_model.parameter_set import ParameterSet

__all__ = ["drawn_plant"]


def drawn_plant(truth: ParameterSet, deviation: float, rng: np.random.Generator) -> Plant:
    """Return a plant like `truth` with each value times exp(s e), e standard normal.

    s is the value's stated standard deviation over the value or, where none is stated, `deviation`; 0 for all where
    `deviation` is 0. The ramp limit is kept, and so are effects. A value stays within what its model admits.
    """
    values = {}
    for name, parameter in truth.parameters.items():
        draw = float(rng.standard_normal())
        stated, value = parameter.standard_deviation, parameter.value
        share = deviation if stated is None or value == 0.0 else abs(stated / value)
        if name == "u_dot_max" or deviation == 0.0:
            share = 0.0
        definition = truth.model.definition(name)
        values[name] = min(max(value * exp(share * draw), definition.lower), definition.upper)
    return Plant(coefficients=truth.model.coefficients(values), effects=truth.effects)
