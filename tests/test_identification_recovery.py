"""Recovery: 95 % intervals of simulated experiments hold the truth as often as they state, law by law."""

import dataclasses

import pytest

from recovery import recovery
from thinned import exhaustive_but
from vibrocap.physics import catalogue
from vibrocap.physics.friction.curves import Exponential
from vibrocap.physics.friction.hysteresis import Dahl

# What the defaults of the laws leave out, or make so large that it hides the rest: viscous friction, wide smoothing,
# and behind a joint with play less bristle damping, which at its default strikes like a hammer.
CHANGES = {"viscous_damping": 0.05, "smoothing_velocity": 0.02}
SLOW = [name for name in catalogue.laws() if name not in ("exponential", "dahl")]
NAMES = [*SLOW, "anisotropic-dahl", "backlash-lugre"]
LONG = ("maxwell-slip", "elasto-plastic", "lugre", "anisotropic-dahl", "backlash-lugre")  # 10 s and more each


def truth(name: str):
    law = catalogue.law(name)()
    changes = {field: value for field, value in CHANGES.items() if hasattr(law, field)}
    if hasattr(law, "gap"):
        changes["bristle_damping"] = 0.2
    return dataclasses.replace(law, **changes)


def least(repetitions: int) -> int:
    """Intervals that must hold: for a coverage of 95 % fewer would happen once in 1000 parameters."""
    from scipy.stats import binom

    return int(binom.ppf(1e-3, repetitions, 0.95))


def check(found):
    assert found.failed == 0
    assert found.identifiable
    wrong = {p.name: p.inside for p in found.identifiable if p.inside < least(found.repetitions)}
    assert not wrong
    return {p.name for p in found.identifiable}


@pytest.mark.slow
@pytest.mark.parametrize("law", [Exponential(), Dahl()], ids=lambda law: law.name)
def test_intervals_hold_the_truth(law):
    found = recovery(law, repetitions=16, starts=2, intervals="covariance")
    assert check(found) == {p.name for p in found.parameters}
    assert all(p.width < 0.05 for p in found.parameters)


def test_intervals_that_were_half_as_wide_would_be_seen(monkeypatch):
    from vibrocap.identification.inference import uncertainty

    plain = uncertainty.inverse
    monkeypatch.setattr(uncertainty, "inverse", lambda matrix: 0.25 * plain(matrix))
    found = recovery(Exponential(), repetitions=16, starts=2, intervals="covariance")
    assert min(p.inside for p in found.parameters) < least(16)


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([i for i, name in enumerate(NAMES) if name not in LONG][::4], NAMES))
def test_intervals_of_every_law_hold_the_truth(name):
    check(recovery(truth(name), repetitions=12, starts=8 if "backlash" in name else 4))
