"""The loops: how a motion begins on a lane, and one step with its first event (`one_step`), from step to step,
from run to run.

Lanes are taken one after another (`one_by_one`) or all at once (`simd_step`, `side_by_side`); a lane that has ended its
run takes the next one from the queue (`run_queue`). Or a caller asks for any length of time (`stepper`).
"""
