"""Places of a lane's own: time, side, states and series, see `memory_layout.py`."""

STATUS = PENDING = TIME = PERIOD = TAIL = SIDE = CAME_FROM = TOLERANCE = CONTACT_RESIDUAL = 0
STATE = PARAMETER = SCALE = SERIES = WORK = 0
