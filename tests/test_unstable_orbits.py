"""Orbits that no simulation keeps: a start near one is followed on, and what it gives way to is said.

Slow: shooting needs the kernels of the tangents.
"""

import json
import math

import numpy as np
import pytest

import vibrocap as vc
from cases import printed, printed_json
from thinned import exhaustive_but
from vibrocap.cli import main as cli
from vibrocap.motion.simulate import period_marks
from vibrocap.orbits.closing import orbit as orbits
from vibrocap.orbits.maps.stroboscopic_map import state_vector

pytestmark = pytest.mark.slow
START = {"angle": math.pi / 3}
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}
DRIFTS = {"exponential": 0.16434774668, "lugre": 0.10718716752}


def first_set(law):
    return vc.System(vc.PendulumCapsule(), LAWS[law], vc.Harmonic())


def symmetric(law):
    """The unstable symmetric orbit between the twins."""
    orbit = vc.orbit(first_set(law), initial=START, half=True)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.symmetric
    assert orbit.unstable
    return orbit


@pytest.mark.parametrize("law", exhaustive_but([0], [*LAWS]))
def test_a_start_near_a_saddle_leads_to_what_the_capsule_does(law):
    """Pushed off it goes to both twins; nearer than 1e-8 the errors of a run decide which way it goes."""
    saddle = symmetric(law)
    reached = saddle.pushed_off()
    assert sorted(each.drift for each in reached) == pytest.approx([-DRIFTS[law], DRIFTS[law]], abs=1e-10)
    assert all(each.stable for each in reached)
    for off in (0.0, -1e-10, 1e-7):
        start = saddle.state | {"angle": saddle.state["angle"] + off}
        orbit = vc.orbit(first_set(law), initial=start)
        assert orbit.status is vc.OrbitStatus.CONVERGED
        assert orbit.stable
        assert abs(orbit.drift) == pytest.approx(DRIFTS[law], abs=1e-10)
    _, marks = period_marks(first_set(law), periods=400, initial=start, tolerance=1e-12)
    assert orbit.drift == pytest.approx(marks[-1, 2] - marks[-2, 2], abs=1e-9)


def test_the_saddle_that_was_passed_is_kept(monkeypatch):
    """The run stands still on LuGre's symmetric orbit, long enough to count as settled."""
    saddle = symmetric("lugre")
    orbit = vc.orbit(first_set("lugre"), initial=saddle.state)
    assert orbit.passed.symmetric
    assert orbit.passed.unstable
    assert orbit.passed.state["angle"] == pytest.approx(saddle.state["angle"], abs=1e-9)
    monkeypatch.setattr(orbits, "orbits_reached", lambda *given: ([], np.array([-1, -1]), None))
    lost = vc.orbit(first_set("lugre"), initial=saddle.state)  # it leaves, and does not settle
    assert lost.status is vc.OrbitStatus.NOT_SETTLED
    assert lost.passed.unstable


def test_an_orbit_that_went_astray_is_not_claimed(monkeypatch):
    """Planted: Newton's method leads to the mirror-image solution of what was simulated."""
    real = orbits.closed

    def elsewhere(map_, state, *rest):
        return real(map_, state_vector(map_.system, real(map_, state, *rest).mirrored_state), *rest)

    monkeypatch.setattr(orbits, "closed", elsewhere)
    orbit = vc.orbit(first_set("exponential"), initial=START)
    assert orbit.status is vc.OrbitStatus.NOT_CONVERGED


def test_a_stable_orbit_cannot_be_pushed_off():
    with pytest.raises(ValueError, match="a multiplier outside the unit circle"):
        vc.orbit(first_set("exponential"), initial=START).pushed_off()


def written_case(path, law, start):
    vc.save_case(first_set(law), path, initial=start)
    return path


def test_command_does_not_present_an_unstable_orbit_as_what_happens(tmp_path, capsys):
    case = written_case(tmp_path / "case.toml", "lugre", symmetric("lugre").state)
    text = printed(capsys, "orbit", case)
    assert "stable        yes" in text
    assert "passed        the start leads close to an orbit of drift 0 on which no motion stays" in text
    assert text.count("successor") == 2
    record = printed_json(capsys, "orbit", case)
    assert record["stable"] is True
    assert abs(record["drift"]) == pytest.approx(DRIFTS["lugre"], abs=1e-10)
    drifts = sorted(each["drift"] for each in record["unstable_orbit"]["gives_way_to"])
    assert drifts == pytest.approx([-DRIFTS["lugre"], DRIFTS["lugre"]], abs=1e-10)


def test_command_says_that_nothing_settled(tmp_path, capsys):
    case = written_case(tmp_path / "case.toml", "exponential", START)
    assert cli.main(["orbit", str(case), "--settle-periods", "3", "--json"]) == 3
    output = capsys.readouterr()
    record = json.loads(output.out)
    assert (record["status"], record["stable"], record["stability"]) == ("not settled", False, "not known")
    assert record["class"]["kind"] in ("period-1", "not settled")  # it would be there soon
    assert "Raise `settle_periods`" in output.err
