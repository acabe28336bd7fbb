"""A motion that goes on by any length of time, as its caller asks: `take_step`, after `begin_motion`; then `look_at`.

Nothing is recorded but how often each kind of event occurred, and which was the last (`event_counts`). How a motion
passes to the instant that is asked for differs with its drive: one of its own goes on by steps of the kernel's own
choice, from which the instant is read (`own_drive`); an input is known up to that instant only (`held_input`).
"""
