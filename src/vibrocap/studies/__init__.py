"""Studies: questions asked of many motions, planned, run, and stored so that they can resume after anything.

Given a system and what varies (axes, a list of cases, a design of experiments), `plan/` gives a checked `Study`, or
every complaint at once. `sweep` and `adaptive` run it tile by tile, here or by `workers`, into a `store/`, and
give back a labelled dataset, in which a run that failed says so.
"""
