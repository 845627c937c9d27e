"""Exchanged sets are rated as explicit least squares rates them."""

from dataclasses import replace

import numpy as np
import pytest
from spring import SLOTS, recorded, suspects

from system_identification.exchange import exchanges
from system_identification.hypothesis import weighed
from system_identification.noise import whitener
from system_identification.rating import tried
from system_identification.traces import traces_of


def _beside(names, system):
    chosen = tuple(each for name in names for each in suspects() if each.effect == name)
    posed, x = system.with_effects(tuple(SLOTS[name] for name in names)), np.array([0.0, 0.0, *(0.2 for _ in names)])
    return weighed(posed, chosen, x, whitener(posed, x))


def test_an_exchange_costs_what_least_squares_says():
    found = _beside(("friction", "scale"), recorded(61, push=0.5, friction=0.8, cubic=1.0))
    fitted = found.fitted
    (cubic,) = (replace(each, grid=np.array([[0.2]])) for each in suspects() if each.effect == "cubic")
    (trial,) = tried(fitted, [cubic], lambda each: found.system.tried(fitted.x, each))
    proposals = exchanges(found, [trial], 10)
    assert all(len(each.suspects) == 2 and cubic in each.suspects for each in proposals)
    traces = traces_of(fitted, found.suspects)
    traces["cubic"] = trial.changes[0].astype(float)

    def cost(names):
        target = fitted.white + sum(found.noise.whiten(traces[name]) for name in found.keys)
        scale = np.sqrt(fitted.prior)
        prior = np.hstack((np.diag(scale), np.zeros((2, len(names)))))
        rows = np.column_stack([fitted.jacobian[:, :2], *(found.noise.whiten(traces[name]) for name in names)])
        whole, right = np.vstack((rows, prior)), np.concatenate((target, -scale * fitted.x[:2]))
        left = right - whole @ np.linalg.lstsq(whole, right, rcond=None)[0]
        return float(left @ left)

    rated = {frozenset(each.effect for each in one.suspects): one.ahead for one in proposals}
    assert max(rated.values()) > 0.0  # what was hidden explains more
    for names, ahead in rated.items():
        assert ahead == pytest.approx(0.5 * (cost(found.keys) - cost(sorted(names))), rel=1e-3, abs=0.01)
