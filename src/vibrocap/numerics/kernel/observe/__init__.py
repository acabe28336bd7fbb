"""Hooks that the loop calls at every piece, event and period of a motion.

`record` keeps all of one motion on a trace. `window` keeps measures only, over a window that begins when the motion has
settled (`settle`): integrals and peaks (`accumulators`), time at rest and mode sequence.
"""
