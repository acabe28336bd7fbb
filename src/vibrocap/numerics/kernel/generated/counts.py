"""Places of what a lane counts: periods and events, see `memory_layout.py`."""

PERIOD_COUNT = WHOLE_PERIODS = ARRIVING = EVENTS = EVENT_LIMIT = IDLE = 0
