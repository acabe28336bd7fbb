"""What many starts lead to: attractors, their basins, and whether a motion is periodic, quasi-periodic or chaotic.

Given a system and ranges of starts, `attractors` and `basins` give the motions that attract them and how many each
attracts; `bifurcation_diagram` sweeps a parameter up and down by simulation; `classify`, `lyapunov_exponent` and
`zero_one_test` say what one motion becomes. Where nothing drives the system in time, motions end at equilibria or on
cycles with a period of their own (`classification`).
"""
