"""Places of what a lane knows of the trace, with pieces, events and tables of a drive, see `memory_layout.py`."""

PIECES = PIECE_LIMIT = PIECE_START = RECORDED_EVENTS = RECORDED_EVENT_LIMIT = RECORDED_EVENT_START = 0
SEGMENT = CYCLE = TABLE = SEGMENT_COUNT = TABLE_START = TABLE_STRIDE = UNTIL = 0
