"""`vibrocap passes`: when a state of a motion passes a value."""

from pathlib import Path

from vibrocap.arguments import suggestion
from vibrocap.cli.options import Refusal, refusing
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.json_text import json_text


def passes(case: Path, /, *, state: str, value: float = 0.0, json: bool = False) -> int:
    """The times at which a state of a motion passes a value, as exact as the motion is.

    Exit code 3: the run ended early; the times until then are printed.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    state
        a state of the system, such as angle
    value
        the value that is passed, of a case in SI in the unit of the state
    json
        print one JSON object in full precision instead of lines
    """
    given = read_source(case)
    if state not in given.system.state_names:
        raise Refusal(f"--state: no state is called {state!r}; {suggestion(state, given.system.state_names)}")
    with progress("Simulating") as report:
        motion = given.simulate(report)
    with refusing("value"):
        times = motion.crossings(state, value).tolist()
    if json:
        print(json_text({"state": state, "value": value, "times": times}))
    else:
        page = Page()
        for time in times:
            page.say(said(time, motion.unit_of("end")))
    if not motion.run_status.ok:
        complain(motion.status.text)
        return INCOMPLETE
    return OK
