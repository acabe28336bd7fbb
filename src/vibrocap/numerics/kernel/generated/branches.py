"""The guards of the branches of law and machine: at a zero of one, the equations go over to another of their pieces."""

SWITCHES = 1  # how many guards there are
LOCATED = (1,)  # of each guard: whether it is a series, whose zero is an event, or asked where a step starts
BRANCHES = 1  # how many of them belong to branches; behind them stand bounds at which a run ends
BOUND_KINDS = (0,)  # number of each bound among the kinds that there are
LAW_BRANCHES = 1  # how many of those are the law's, which stand before the machine's
SWITCH = 0  # first coefficient of the series of the guards (of the machine's to ORDER, of others to ORDER - 1)
IMPACT = -1  # place among what is integrated of the energy lost in impacts; -1: there is none
OCCURRED = -1  # place of how often each guard of the machine fell to zero; -1: it is not counted
