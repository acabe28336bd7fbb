"""Where stable motions end within the range of a branch: what ends them, what follows, in data, text and picture.

A pendulum capsule in SI, over 3.5 to 4.6 Hz: its branch of travelling motions covers a part of that only.
"""

import pytest

import vibrocap as vc
from vibrocap.case.case import case_from_text
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.plotting.steady.branches import ENDS, LEADS, branch_figure, draw_branch
from vibrocap.quantities.dimensional import computed

CASE = """\
[machine]
kind = "pendulum-capsule"
pendulum_mass_kg = 0.1
pendulum_length_m = 0.04
capsule_mass_kg = 0.48
stiffness_N_m_per_rad = 0.053
damping_N_m_s_per_rad = 0.00103
normal_load = "weight"
[friction]
law = "exponential"
coulomb_coefficient = 0.1
static_coefficient = 0.29
decay_rate_s_per_m = 12.8
[drive]
waveform = "harmonic"
amplitude_N_m = 0.096
frequency_Hz = 3.9
[initial]
angle_rad = 1.0
"""
LIGHTER = {
    "capsule_mass_kg = 0.48": "capsule_mass_kg = 0.089",
    "stiffness_N_m_per_rad = 0.053": "stiffness_N_m_per_rad = 0.0463",
    "damping_N_m_s_per_rad = 0.00103": "damping_N_m_s_per_rad = 0.001228",
    "coulomb_coefficient = 0.1": "coulomb_coefficient = 0.19",
    "static_coefficient = 0.29": "static_coefficient = 0.37",
    "amplitude_N_m = 0.096": "amplitude_N_m = 0.08826",
}


def case_of(changes):
    text = CASE
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return case_from_text(text)


def diagram(case, low, high):
    return vc.branches(case.system, "drive.frequency_Hz", (low, high), initial=case.initial)


@pytest.fixture(scope="module")
def partial():
    """The travelling branch ends at both sides; the symmetric one did not close from the start."""
    return diagram(case_of({}), 3.5, 4.6)


@pytest.fixture(scope="module")
def folded():
    """Travel ends at a fold, beyond which a simulation comes to rest on the symmetric motion."""
    return diagram(case_of(LIGHTER), 3.6, 3.75)


@pytest.mark.slow
def test_a_family_that_covers_a_part_is_joined_to_what_goes_on_beside_it(partial):
    """Only the travelling branch was found, over 3.57 to 4.15 Hz, with nothing said of what is beyond."""
    order = sorted(range(2), key=lambda number: partial.branches[number].symmetric)
    travelling, symmetric = (partial.branches[number] for number in order)
    assert travelling.ends == (BranchEnd.PITCHFORK, BranchEnd.PITCHFORK)
    assert symmetric.symmetric
    assert symmetric.ends == (BranchEnd.PARAMETER_BOUND, BranchEnd.PARAMETER_BOUND)
    child, parent = order
    joins = sorted((join.parent, join.child, join.end) for join in partial.joins)
    assert joins == [(parent, child, -1), (parent, child, 0)]
    assert partial.transitions == ()  # both ends are bifurcations of what is followed
    low, high = travelling.parameter.min(), travelling.parameter.max()
    for value in (0.5 * (partial.between[0] + low), 0.5 * (high + partial.between[1])):
        near = min(range(len(symmetric)), key=lambda i: abs(symmetric.parameter[i] - value))
        assert symmetric.stable[near]


@pytest.mark.slow
def test_stable_motions_that_end_at_a_fold_say_so_and_what_follows(folded):
    """And a simulation of one's own beyond the fold ends where the diagram says."""
    (transition,) = folded.transitions
    branch, reached = folded.branches[transition.branch], folded.branches[transition.reached]
    (fold,) = branch.kind(SpecialKind.FOLD)
    assert transition.why == "fold"
    assert transition.parameter == fold.parameter
    assert transition.leads_to == f"[{transition.reached}]"
    assert reached.symmetric
    span = folded.between[1] - folded.between[0]
    start = dict(zip(folded.system.state_names, map(float, branch.states[transition.point]), strict=True))
    for beyond, symmetric in ((0.02 * span, True), (-0.02 * span, False)):
        system = folded.system.with_parameters({"drive.frequency_Hz": fold.parameter + beyond})
        assert vc.orbit(system, initial=start).symmetric is symmetric
    assert f"[{transition.branch}] is stable up to drive.frequency_Hz = " in str(folded)
    assert f"(fold); beyond it a simulation leads to [{transition.reached}]" in str(folded)


@pytest.mark.slow
def test_a_torus_is_born_below_a_speed_of_the_belt():
    """Steady sliding that is shaken: the place is that of an event solver of its own, in long double."""
    law, drive = vc.Exponential(0.5, 1.0, 2.0), vc.Harmonic(amplitude=0.1, frequency=1.37)
    belt = vc.System(vc.Oscillator(damping=0.1, belt_speed=1.2), law, drive)
    diagram = vc.branches(belt, "machine.belt_speed", (1.1, 1.25), initial={"position": 0.5, "sliding_velocity": -1.2})
    (torus,) = diagram.branches[0].special_points
    assert (torus.kind, torus.stability) == (SpecialKind.NEIMARK_SACKER, "gained")
    assert torus.parameter == pytest.approx(1.1634213253728, abs=1e-11)
    assert torus.multipliers[0] == pytest.approx(-0.12629694 + 0.99199248j, abs=1e-8)
    ends = "(Neimark-Sacker); beyond it a simulation leads to a motion that does not settle"
    assert f"[0] is stable down to machine.belt_speed = 1.163421325 {ends}" in str(diagram)


@pytest.mark.slow
def test_what_cannot_be_run_beyond_is_named():
    """Driven harder the capsule lifts off, which ends the branch."""
    drive = vc.Biharmonic(amplitude=1.8, second_amplitude=0.4)
    light = vc.System(vc.PendulumCapsule(normal_load="dynamic"), vc.Exponential(), drive)
    branches = vc.branches(light, "drive.amplitude", (1.8, 2.0))
    (transition,) = branches.transitions
    assert (transition.reached, transition.leads_to) == (None, "a run that ends by lift off")
    assert "beyond it a simulation leads to a run that ends by lift off" in str(branches)
    assert ENDS in [text.get_text() for text in branch_figure(branches).legends[0].get_texts()]


@pytest.mark.slow
def test_the_picture_shows_what_follows(folded):
    """An arrow for each of the mirror-image solutions, from the last stable motion to the branch that is reached."""
    figure = branch_figure(computed(folded))
    assert LEADS in [text.get_text() for text in figure.legends[0].get_texts()]
    (transition,) = folded.transitions
    for ax in (figure.axes[0], draw_branch(computed(folded))):
        arrows = [text for text in ax.texts if getattr(text, "arrow_patch", None) is not None and not text.get_text()]
        assert len(arrows) == 2
        for arrow in arrows:
            assert arrow.xy == (pytest.approx(transition.parameter), pytest.approx(0.0, abs=1e-9))
