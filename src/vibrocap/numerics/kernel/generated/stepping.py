"""Places by which a lane chooses its method and its step, see `memory_layout.py`."""

ZEROS = STIFF = PATIENCE = TAYLOR_STEPS = IMPLICIT_STEPS = IMPLICIT_STEP = EXPLICIT_STEP = DAMPED_STEP = DECAY_RATE = 0
HOLD_RATE = SAFE_SPEED = UNSAFE_SPEED = FAR_SPEED = NEAR_SPEED = 0
