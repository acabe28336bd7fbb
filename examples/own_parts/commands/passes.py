"""`vibrocap passes`: when a state of a motion passes a value."""

from vibrocap.arguments import Complaints, suggestion
from vibrocap.cli.command import Answer, OfCase, Report, command
from vibrocap.cli.completers import states_of_case
from vibrocap.cli.options import JSON, option, required
from vibrocap.cli.terminal import said


class PassesRequest(OfCase):
    state: str = required("a state of the system, such as angle", offers=states_of_case)
    value: float = option("the value to pass, of a case in SI in the unit of the state", 0.0)
    json: bool = JSON

    def plan(self, refused: Complaints) -> None:
        """A state of the case."""
        if self.state not in (names := self.setup.system.state_names):
            refused.add("--state", f"no state is called {self.state!r}; {suggestion(self.state, names)}")


@command("run", "vibrocap passes examples/travels-by-stick-slip.toml --state angle", doing="Simulating")
def passes(request: PassesRequest, report: Report) -> Answer:
    """When a state of a motion passes a value.

    The times are as exact as the motion. Exit code 3: the run ended early; the times until then are printed.
    """
    motion = request.setup.simulate(report)
    times = motion.crossings(request.state, request.value).tolist()
    record = {"state": request.state, "value": request.value, "times": times}
    text = "\n".join(said(time, motion.unit_of("end")) for time in times)
    return Answer(record, text, incomplete="" if motion.run_status.ok else motion.status.text)
