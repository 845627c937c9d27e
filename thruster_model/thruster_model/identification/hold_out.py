"""How well a model predicts runs that its fit has not seen: each run left out in turn."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from thruster_model.identification.evaluation import Evaluation, evaluate
from thruster_model.identification.experiment import Experiment
from thruster_model.identification.fit import FitOptions, fit, noise_of
from thruster_model.parameter_set import ParameterSet

__all__ = ["leave_one_out"]


def leave_one_out(
    start: ParameterSet,
    experiments: Sequence[Experiment],
    options: FitOptions | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Evaluation:
    """Return the errors on each run of a fit to all others; every fit starts from `start`.

    Of a left-out run only its own clocks are adjusted, as they are for any parameter set that is judged on it.
    """
    noise = noise_of(experiments)
    collected = {}
    for index, left_out in enumerate(experiments):
        progress(f"left out: {left_out.name}")
        others = [e for e in experiments if e is not left_out]
        found = fit(start, others, replace(options or FitOptions(), passes=2)).parameter_set
        single = evaluate(found, [left_out], noise)
        collected.update({(index, signal): values for (_, signal), values in single.residuals.items()})
    return Evaluation(residuals=collected, noise=noise)
