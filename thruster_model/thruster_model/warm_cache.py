"""Compile all kernels into the cache:   python -m thruster_model.warm_cache"""

import numpy as np

from thruster_model.flow_tank import simulate
from thruster_model.identification.experiment import Experiment, Measurement
from thruster_model.identification.prediction import predict
from thruster_model.models import MODELS


def main() -> None:
    """Run each kernel once with arguments of the types that it is used with."""
    model = MODELS["hq"]
    coefficients = model.coefficients({d.name: d.scale for d in model.parameters})
    simulate(coefficients, np.ones(3), 0.01)
    cell = Measurement(signal="speed", time=np.array([0.01]), values=np.array([0.0]), width=0.01, noise=1.0)
    experiment = Experiment(name="warm", dt=0.01, throttle=np.ones(3), measurements={"speed": cell})
    predict(experiment, coefficients)


if __name__ == "__main__":
    main()
