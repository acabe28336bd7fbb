"""One source, however it runs: plain Python = compiled, an edit is seen (lanes: `test_ensemble.py`)."""

import hashlib
import math

import numpy as np
import pytest

import vibrocap as vc
import vibrocap.motion.recording.equations as recordings
from plain_kernels import kernel_of
from systems import two_blocks
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.kernel.codes import DONE
from vibrocap.numerics.run.budget import Budget, Form, MotionStart
from vibrocap.numerics.run.motion import kernel, recorded_run

LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre(), "stiff lugre": vc.LuGre(bristle_stiffness=1e4)}


def system_with(law, mass_ratio=2.5, amplitude=1.8):
    return vc.System(vc.PendulumCapsule(mass_ratio=mass_ratio), law, vc.Harmonic(amplitude=amplitude))


SYSTEMS = {name: system_with(law) for name, law in LAWS.items()} | {
    "impacts": vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Harmonic()),
    "two contacts": two_blocks(duration=4.0),
    "limited controller": vc.System(vc.Oscillator(), vc.Coulomb(), vc.Harmonic(), controller=vc.PositionPID(limit=0.5)),
}


def start_of(system, angle=math.pi / 3):
    return [angle, *[0.0] * (len(system.state_names) - 1)]


def run(system, periods, plain, tolerance=1e-9):
    return recorded_run(
        MotionStart(equations(system), parameter_values(system), start_of(system), system.drive.period),
        Budget(periods, tolerance, 10_000, 10**6),
        Form(plain=plain),
    )


@pytest.mark.parametrize("name", SYSTEMS)
def test_plain_python_is_the_compiled_kernel(name):
    """The same steps and events; numbers differ by fused multiply-adds and the compiler's sin, cos and exp.

    That is an ulp per operation, some 1e-13 in a state after half a period, and more where a step's length follows from
    the logarithm of a coefficient that nearly cancels: the tolerance of the run bounds it.
    """
    system, periods = SYSTEMS[name], 0.6
    plain, compiled = run(system, periods, plain=True), run(system, periods, plain=False)
    assert plain.status == compiled.status == DONE
    assert np.array_equal(plain.events[:, 2], compiled.events[:, 2])
    assert plain.events[:, 1] == pytest.approx(compiled.events[:, 1], rel=1e-9)
    assert (plain.taylor_steps, plain.implicit_steps) == (compiled.taylor_steps, compiled.implicit_steps)
    assert plain.taylor_steps > 5
    if name == "stiff lugre":
        assert plain.implicit_steps > 0
    first_plain, first_compiled = plain.pieces[:3], compiled.pieces[:3]
    size = np.abs(first_plain).max(axis=0) + 1.0
    assert np.all(np.abs(first_plain - first_compiled) <= 1e-12 * size)
    assert final(plain) == pytest.approx(final(compiled), abs=1e-10)


def final(recorded):
    """State at the end of the last piece, which both runs put at the same time."""
    return np.polynomial.polynomial.polyval(recorded.piece_lengths[-1], recorded.series[-1:][0].T)


# --- the cache -------------------------------------------------------------------------------------------------------


def linked_text(law):
    return kernel_of(system_with(law)).text


def forget_recordings():
    """As in a new process: equations are recorded anew when next asked for."""
    for name in vars(recordings).values():
        if hasattr(name, "cache_clear"):
            name.cache_clear()


def hashed(text):
    return hashlib.sha256(text.encode()).hexdigest()


def test_an_edited_law_is_another_kernel(monkeypatch):
    """A term dropped from a law changes the linked text, and with it the name under which its kernel is kept."""
    before = hashed(linked_text(vc.LuGre()))
    forget_recordings()
    assert hashed(linked_text(vc.LuGre())) == before

    def edited(self, velocity, internal, side, load):
        (bristle,) = internal
        rate = velocity - self._slip_rate(velocity, internal, side, load)
        return self.bristle_stiffness * bristle + self.bristle_damping * rate, (rate,)

    monkeypatch.setattr(vc.LuGre, "force", edited)
    forget_recordings()
    try:
        assert hashed(linked_text(vc.LuGre())) != before
    finally:
        monkeypatch.undo()
        forget_recordings()


def test_parameters_do_not_ask_for_another_kernel():
    """New numbers reuse the compiled kernel; a whole exponent and a rounded one are two forms of the equations."""

    def entry(law):
        return kernel(equations(system_with(law, 0.3)), 12)[1]

    assert entry(vc.Exponential(decay_rate=3.0)) is entry(vc.Exponential())
    assert linked_text(vc.LuGre(bristle_stiffness=7.0)) == linked_text(vc.LuGre())
    assert linked_text(vc.LuGre(stribeck_exponent=1.4)) == linked_text(vc.LuGre(stribeck_exponent=1.6))
    assert linked_text(vc.LuGre(stribeck_exponent=1.0)) != linked_text(vc.LuGre())


def test_reordered_text_is_the_same_text():
    """Recording is deterministic: the text does not depend on what was recorded before, so the cache is met again."""
    first = linked_text(vc.LuGre())
    forget_recordings()
    linked_text(vc.Exponential())
    assert linked_text(vc.LuGre()) == first
