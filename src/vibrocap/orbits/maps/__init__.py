"""Maps of the state over periods, and their derivatives.

Given a system and states at the start of a drive period, the stroboscopic map gives the states whole periods later and
the exact derivative, for many runs side by side. The closing map is its mismatch with one parameter as an unknown; the
cycle map is the same for a system that nothing drives in time, where the period is unknown too. Both are residuals of
the walk.
"""
