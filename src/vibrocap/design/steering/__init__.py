"""Steering: a schedule of the drive that brings a machine to a place and holds it there.

Given: a system, a target, how near is near enough, and what is uncertain. Given back: the schedule of a stated family
(bursts of the drive's own waves, each followed by a pause) that arrives soonest or with the least work, as a system
that runs, with what becomes of it in every sample. `trials` runs schedules side by side, `family` says which there are,
`steer` searches, `steering` is the result.
"""
