"""Measures: what is asked of a motion, and of many motions of which nothing else is kept.

Given a `Trajectory`, a function here gives back numbers with what makes them mean something: a velocity with its
window and whether the motion had settled, an energy balance with its residual, a loop with its area (`travel`,
`energy`, `friction_loop`, `sticking`, `settling`). Given a system, `limits` reads off
its friction. Given a system and lists of values, `ensemble` runs it once for each and takes measures, by name, during
the run (`during_run`, `standard`, or a `measure` of one's own).
"""
