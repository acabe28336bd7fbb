"""Progress of long work: a bar where it is asked for, a function where one is given, and "compiling" while it is so."""

import functools
import inspect
import io

import numpy as np
import pytest
from rich.console import Console

import vibrocap as vc
from vibrocap import progress
from vibrocap.numerics import compiler

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
LONG = (
    vc.simulate, vc.sweep, vc.adaptive_map, vc.orbit, vc.branch, vc.branches, vc.attractors, vc.basins, vc.crossing,
    vc.bifurcation_diagram, vc.fit, vc.steady_fit, vc.spring_fit, vc.compare,
)  # fmt: skip


@pytest.fixture
def terminal(monkeypatch):
    """What a terminal shows of bars, which come at once."""
    shown = io.StringIO()
    monkeypatch.setattr("rich.console.Console", functools.partial(Console, file=shown, force_terminal=True, width=100))
    monkeypatch.setattr(progress, "SHOWN_AFTER", 0.0)
    return shown


@pytest.mark.parametrize("function", LONG, ids=lambda function: function.__name__)
def test_whatever_is_long_takes_true_or_a_function(function):
    annotation = str(inspect.signature(function).parameters["progress"].annotation)
    assert "bool" in annotation or annotation.endswith("Progress")


def test_bar_is_shown_and_goes(terminal):
    with progress.bar("Looking") as report:
        report(0.25, "Looking closely")
        progress._bars[0].shown.start()
        progress._bars[0].shown.refresh()
    assert "Looking closely" in terminal.getvalue()
    assert "25%" in terminal.getvalue()
    assert progress._bars == []


@pytest.mark.plain
def test_motion_with_a_bar_is_the_motion_without_one(terminal):
    settings = {"periods": 2, "initial": {"angle": 1.0}}
    assert vc.simulate(SYSTEM, **settings, progress=True) == vc.simulate(SYSTEM, **settings, progress=False)


def test_bar_says_so_while_equations_are_compiled(terminal, monkeypatch):
    descriptions = []

    def object_code(text, target):
        descriptions.append(progress._bars[0]._description())
        return b""

    monkeypatch.setattr(compiler, "object_code", object_code)
    monkeypatch.setattr(compiler, "ir", lambda *given, **options: "")
    monkeypatch.setattr(compiler, "Compiled", lambda code: code)
    monkeypatch.setattr(compiler.cache, "kept", lambda name: None)
    monkeypatch.setattr(compiler.cache, "keep", lambda name, code: None)
    with progress.bar("Simulating"):
        compiler.compiled("nothing that was ever compiled", "advance")
        descriptions.append(progress._bars[0]._description())
    assert descriptions == ["Simulating: compiling", "Simulating"]


def test_function_is_called_with_the_share_done():
    orbit = vc.orbit(SYSTEM, initial={"angle": 1.0})
    shares = []
    vc.branch(SYSTEM, "machine.mass_ratio", (2.45, 2.55), orbit=orbit, progress=shares.append)
    assert shares == sorted(shares)
    assert 0.0 < shares[0] < 0.5
    assert shares[-1] == 1.0
    shares.clear()
    vc.simulate(SYSTEM, periods=3, progress=shares.append)
    assert shares[-1] == 1.0


def test_what_is_no_progress_is_refused_by_name():
    for function in (functools.partial(vc.simulate, SYSTEM), functools.partial(vc.orbit, SYSTEM)):
        with pytest.raises(ValueError, match="progress should be True or a function of the share done, got 'bar'"):
            function(progress="bar")


def test_done_of_so_many_becomes_a_share():
    @progress.shows_progress("Counting", counted=True)
    def counts(*, progress=None):
        return progress

    results = []
    assert counts(progress=results.append).__self__ is results
    assert counts() is None
    assert counts(progress=True).func is progress._count


def test_an_ensemble_takes_a_bar_a_function_or_nothing():
    over = {"machine.mass_ratio": np.linspace(2.0, 3.0, 9)}
    begun = []
    plain = vc.ensemble(SYSTEM, over, periods=2)
    for given in (True, begun.append):
        assert np.array_equal(
            vc.ensemble(SYSTEM, over, periods=2, progress=given)["mean_velocity"], plain["mean_velocity"]
        )
    assert begun[0] == 0
    with pytest.raises(ValueError, match="progress"):
        vc.ensemble(SYSTEM, over, periods=2, progress="yes")
