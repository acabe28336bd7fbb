"""Records: what was measured, with its units, checked; this room knows no physics of ours.

Given a file, or the name of a published data set, it gives back a `Record` (force and motion of one contact over time,
in SI) or a `Pull` (the force on a pulled slider), prepared for a fit where that is asked for; complaints are errors,
what only looks wrong is a warning. Of a force with stick-slip it finds the phases, the period and the regime. Files are
read in `reading/`.
"""
