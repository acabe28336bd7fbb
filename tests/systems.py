"""Systems that several files of tests ask."""

import vibrocap as vc


def capsule(law=None, **parameters):
    """The capsule of the paper."""
    return vc.System(vc.PendulumCapsule(), law or vc.Exponential(), vc.Harmonic()).with_parameters(parameters)


def two_blocks(belt=0.2, duration=10.0):
    """Galvanetto and Bishop: unit masses and wall springs, coupling 1.2, friction of block i s_i/(1 + 3|v|)."""
    laws = [vc.HyperbolicStribeck(0.0, level, 1.0 / 3.0) for level in (1.0, 1.3)]
    row = vc.TwoBlockRow(coupling_stiffness=1.2, belt_speed=belt)
    return vc.System(row, laws, vc.Constant(duration=duration))
