"""Bristles of a contact, as friction laws and observers of friction know them: their level and how fast they slip."""

from vibrocap.physics.elementary import exp, power


def stribeck_curve(speed, least, most, velocity, exponent):
    """least + (most - least) exp(-|speed/velocity|^exponent), for a speed >= 0."""
    return least + (most - least) * exp(-power(speed / velocity, exponent))


def bristle_slip(speed, bristle, stiffness, level):
    """Velocity at which bristles of this deflection slip, |v| xi/g with g = level/stiffness; speed: |v|."""
    return stiffness * speed * bristle / level
