"""What each lane carries from step to step, by name; where it stands says `memory_layout.py`."""

# Entries of `ints`, one number per lane each, or per contact of the lane.
INT_ENTRIES = (
    "STATUS",
    "PERIOD_COUNT",  # whole periods completed
    "WHOLE_PERIODS",  # periods to run
    "TO_DECIDE",  # [contacts] 1: it is at rest and not decided yet whether it sticks; 2: its series decide
    "ZEROS",  # [contacts] how many coefficients of the velocity are known to vanish at the start of the step
    "GAVE_WAY",  # [contacts] 1: it has given way at this instant, of several contacts
    "STIFF",  # 1: implicit steps
    "PATIENCE",  # steps until the choice of method is looked at again
    "TAYLOR_STEPS",  # accepted
    "IMPLICIT_STEPS",  # accepted
    "EVENTS",  # in this period
    "EVENT_LIMIT",  # most events allowed in a period
    "ZERO_PROGRESS",  # decisions in a row that did not advance time
    "PENDING",  # 1: the tangent has left a piece and not begun the next one
    "PIECES",  # written to the trace
    "PIECE_LIMIT",
    "RECORDED_EVENTS",  # written to the trace
    "RECORDED_EVENT_LIMIT",
    "PIECE_START",  # place of the first piece on the trace
    "RECORDED_EVENT_START",  # place of the first event on the trace
    # of an ensemble only
    "RUN",  # which run of the trace the lane is on; -1: none
    "STEP_LIMIT",
    "WINDOW",  # periods over which is measured where nothing settles
    "WINDOW_START",  # period at which measuring began; -1: not yet
    "RESPONSE",  # drive periods after which the settled motion repeats; 0: not settled
    "SINCE",  # period from which on it was settled
    "RETURN_COUNT",  # of a system that nothing drives in time: returns so far, see `observe/returns.py`
    "LEFT",  # returns until the window ends
    "QUIET_SINCE",  # first period that began after the last return
    "BY_PLACE",  # 1: returns are passages of a place, as no contact comes to rest
    "PASSED",  # passages of the place since a contact came to rest
    "PASSED_AT",  # steps before the last one
    "MODES",  # a number for the sides at the start of the period and its events
    "LAST_MODES",  # the same of the period before
    "STEADY_MARK",  # for which STEADY has been extrapolated
    "NEXT_TRIAL",  # first mark at which the limit may be tried
    "ON_TRIAL",  # 1: the lane has gone on from that limit; 2: which holds
    "REFUSED_TRIALS",
    "PERIOD_BUDGET",  # periods to run where nothing settles (of lane 0, for all lanes, like all below)
    "EVIDENCE_PERIODS",  # last periods of which evidence is taken where nothing settles; 0: none is taken at all
    "EXTRAPOLATE",  # 1: runs go on from the extrapolated limit of their marks
    "ASKED",  # groups of measures to gather, a sum of the powers of two in `window.py`
    "RESULT_START",  # place of the first result on the trace
    "NEXT_RUN",  # first run of the trace that no lane has begun
    "LAST_RUN",  # end of the runs to begin
    "MORE",  # 1: come back for more runs as soon as a lane is free
    # of drives with corners only
    "SEGMENT",  # present one of the drive
    "CYCLE",  # whole periods of the drive since the period of the run began
    "TABLE",  # place of the run's table of segments on the trace
    "SEGMENT_COUNT",  # of a table (of lane 0, for all lanes, like all below)
    "TABLE_START",  # place of the first table on the trace
    "TABLE_STRIDE",  # from the table of a run to that of the next; 0: one serves all runs
    # of a stepper only
    "BEGUN",  # 1: the motion has begun
    "ENDED",  # status with which the motion has ended; RUNNING: it has not
    "STOPPING",  # 1: it is to stop at the first event
    "STOPPED",  # 1: it has
    "NOTICED",  # events, but for grazes, at the instant at which the next step begins
    "STEPS_PER_CALL",  # most of them
    "NEW_INPUT",  # 1: an input has been set, which the next step takes
    "PIECE_STIFF",  # STIFF of the step within which the clock stands
    "LAST_KIND",  # of event
    "LAST_CONTACT",  # 1 for the first, 0: of none
    "COUNTED",  # [counts] how often events occurred, see `stepper/event_counts.py`
    "WAITING_EVENTS",  # later than the clock
    "WAITING_KIND",  # [waiting] of these
    "WAITING_CONTACT",  # [waiting]
)
# Entries of `floats`, one number per lane each unless sized in `Layout`.
FLOAT_ENTRIES = (
    "TIME",  # since the start of the period
    "PERIOD",  # length of a period
    "HOLD_RATE",  # by which the last term of a holding force follows from the last but two, see `taylor.taylor_step`
    "TAIL",  # time to run after the whole periods
    "SIDE",  # [contacts] +1, -1 sliding; 0 stuck
    "CAME_FROM",  # [contacts] side before it came to rest
    "SIDE_TOLD",  # [contacts] side in the last piece that was recorded
    "TOLERANCE",  # error per step over the natural size of a state
    "IMPLICIT_STEP",  # step that the implicit method proposes, or of the series on a slow manifold
    "EXPLICIT_STEP",  # last step of the Taylor method before the implicit method took over
    "DECAY_RATE",  # of the fastest decay at the start of the step, about; of laws that cannot stick
    "DAMPED_STEP",  # step for which the series has been damped by the step of all lanes; 0: it has not
    "SAFE_SPEED",  # up to which a series is known to see all that the law holds, see `resolved.py`
    "REFUTED_SPEED",  # for which this has been asked, and is not so
    "FAR_SPEED",  # from which on the law holds nothing that a step could notice
    "NEAR_SPEED",  # for which this has been asked, and is not so
    "CONTACT_RESIDUAL",  # largest |contact velocity| at a located event
    "STATE",  # [rows] states and integrals
    "PARAMETER",  # [parameters]
    "SCALE",  # [states] natural size of each state
    # of an ensemble only
    "STEP",  # length of the present step
    "EVENT_CONTACT",  # number of the contact of the event with which the step ends
    "DELAY",  # by which the event comes later, per unit of the tangent
    "INVERSE_SCALE",  # [states] one over SCALE
    "THRESHOLD",  # of settling; 0: the run goes on to its end
    "REMAINING",  # bound of the distance still to go, when the motion was found settled
    "BEGUN_AT",  # time at which the window of a cycle began; -1: of none
    "SETTLED_AT",  # time from which on it was settled
    "RETURN_TIMES",  # [marks] of returns
    "START_STATE",  # [states] at the start of the window
    "MEASURED",  # [measured] what is gathered over the window
    "SLOW",  # [manifolds] 1: the motion is on it, see `step/slow_manifold.py`
    "SWEEPS",  # [manifolds] series since then, of which none was accepted
    "WAIT",  # [manifolds] steps until it is tried again
    "PAUSE",  # [manifolds] how long it waits after the next failure
    "OWN_DECAY",  # [manifolds] rate of decay towards it
    "DRIFT",  # [manifolds] what an error of it does to other states over their natural size, in a unit of time
    "KICK",  # [manifolds] the same while it decays
    "GUESS",  # [manifolds * (order + 1)] series of what is slaved, of the sweep before
    "UNTIL",  # end of the present segment of a drive with corners; of any other, PERIOD stands for it
    # of a stepper only
    "CLOCK",  # time since the motion began
    "CLOCK_REST",  # what rounding leaves of it
    "LENGTH",  # by which the motion is to go on
    "INPUT",  # [coefficients] value, slope and curvature of an input that was set
    "PIECE_CLOCK",  # start of the step within which the clock stands
    "PIECE_TIME",  # the same as TIME
    "PIECE_LENGTH",
    "PIECE_SEGMENT",  # [coefficients + 2] numbers of the drive's segment in that step
    "SHOWN_SIDE",  # [contacts] side at the clock
    "LAST_TIME",  # of the last event
    "WAITING_TIME",  # [waiting] of events that are later than the clock
    "STEADY",  # [states] extrapolated limit of the marks, over natural sizes
    "KEPT",  # [entries] all of the lane above, and of `ints`, while a limit is tried
    "RETURN_MARKS",  # [marks * (states + turns)] the same as MARKS of states at returns
    "MARKS",  # [marks * (states + turns)] stroboscopic states over their natural size, mark k at k modulo `marks`
    "SERIES",  # [series rows * (order + 1)] coefficients of the present step, see `Layout.series_rows`
    "WORK",  # [work size, once for all lanes] of the event search and the implicit step
)
OF_STEPPER = (
    *("BEGUN", "ENDED", "STOPPING", "STOPPED", "NOTICED", "STEPS_PER_CALL", "NEW_INPUT", "PIECE_STIFF", "LAST_KIND"),
    *("LAST_CONTACT", "WAITING_EVENTS", "CLOCK", "CLOCK_REST", "LENGTH", "PIECE_CLOCK", "PIECE_TIME", "PIECE_LENGTH"),
    "LAST_TIME",
)
NOT_OF_STEPPER = (
    *("PENDING", "PIECES", "PIECE_LIMIT", "PIECE_START", "RECORDED_EVENTS", "RECORDED_EVENT_LIMIT"),
    *("RECORDED_EVENT_START", "RUN", "WINDOW", "WINDOW_START", "RESPONSE", "SINCE", "PERIOD_BUDGET", "EXTRAPOLATE"),
    *("MODES", "LAST_MODES", "STEADY_MARK", "NEXT_TRIAL", "ON_TRIAL", "REFUSED_TRIALS"),
    *("EVIDENCE_PERIODS", "ASKED", "RESULT_START", "NEXT_RUN", "LAST_RUN", "MORE", "EVENT_CONTACT", "DELAY"),
    *("INVERSE_SCALE", "THRESHOLD", "REMAINING", "START_STATE"),
)
OF_RETURNS = ("RETURN_COUNT", "LEFT", "QUIET_SINCE", "BY_PLACE", "PASSED", "PASSED_AT", "BEGUN_AT", "SETTLED_AT")
PER_CONTACT = ("TO_DECIDE", "ZEROS", "GAVE_WAY", "SIDE", "CAME_FROM", "SIDE_TOLD")
