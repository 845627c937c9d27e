"""What a run left out is foretold as, against the conditional density of all rows at once."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from spring import SLOTS, recorded, suspects

from system_identification.hypothesis import weighed
from system_identification.left_out import folds_of, foretold, helps_by
from system_identification.noise import whitener


def test_a_run_is_as_probable_as_it_is_given_the_rows_of_all_others():
    system = recorded(61, push=0.5)
    x = np.zeros(2)
    found = weighed(system, (), x, whitener(system, x))
    found = replace(found, loose=found.loose._replace(levels={"parameters": 0.7, "rest": 0.5}))
    bare, folds = replace(found.noise, loose=None), folds_of(system)
    own = folds[:, None] == folds
    unknown, rest = (
        bare.filtered(found.fitted.sensitivities),
        bare.filtered(np.full((folds.size, 1), 0.5 * system.noise)),
    )
    covariance = np.eye(folds.size) + (unknown / bare.prior(system)) @ unknown.T
    covariance += own * (0.49 * unknown @ unknown.T)
    for k in np.unique(folds):
        here = np.where(folds[:, None] == k, rest, 0.0)
        covariance += here @ here.T
    rows = bare.whiten(found.fitted.residuals) + unknown @ found.fitted.x
    assert foretold(found) == pytest.approx(_given_the_others(rows, covariance, folds, bare.deviations), abs=0.02)


def test_quarters_of_a_single_run_count_as_runs_that_rest_elsewhere():
    system = recorded(63, push=0.5, runs=1)
    x = np.zeros(2)
    found = weighed(system, (), x, whitener(system, x))
    found = replace(found, loose=found.loose._replace(levels={"rest": 0.5}))
    bare, folds = replace(found.noise, loose=None), folds_of(system)
    unknown, rest = (
        bare.filtered(found.fitted.sensitivities),
        bare.filtered(np.full((folds.size, 1), 0.5 * system.noise)),
    )
    covariance = np.eye(folds.size) + (unknown / bare.prior(system)) @ unknown.T
    covariance += (folds[:, None] == folds) * (rest @ rest.T)
    rows = bare.whiten(found.fitted.residuals) + unknown @ found.fitted.x
    assert foretold(found) == pytest.approx(_given_the_others(rows, covariance, folds, bare.deviations), abs=0.02)


def _given_the_others(rows, covariance, folds, deviations):
    """Return the log density of each fold given the rows of all others, (F,)."""
    together = _log_density(rows, covariance)
    return [
        together - _log_density(rows[folds != k], covariance[np.ix_(folds != k, folds != k)])
        - np.sum(np.log(deviations[folds == k])) + 0.5 * np.sum(folds == k) * np.log(2.0 * np.pi)
        for k in np.unique(folds)
    ]  # fmt: skip


def _log_density(rows, covariance):
    return multivariate_normal(np.zeros(rows.size), covariance).logpdf(rows)


def test_an_effect_that_is_there_foretells_a_new_run_better_and_one_that_is_not_does_not():
    system = recorded(62, push=0.5, friction=0.8)
    gained = {}
    for name in ("friction", "cubic"):
        suspect = next(each for each in suspects() if each.effect == name)
        posed, x = system.with_effects((SLOTS[name],)), np.array([0.0, 0.0, 0.1])
        found, none = (
            weighed(posed, (suspect,), x, whitener(posed, x)),
            weighed(system, (), x[:2], whitener(system, x[:2])),
        )
        gained[name] = foretold(found) - foretold(none)
    assert helps_by(gained["friction"]) > 0.99 and gained["friction"].sum() > 10.0
    assert gained["cubic"].sum() < 5.0
