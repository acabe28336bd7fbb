"""`vibrocap robust`: how sure a measure of a case is where some of its quantities are not known exactly."""

from vibrocap.cli.command import Answer, OfCase, Report, command
from vibrocap.cli.options import FOR, JSON, REQUIRED, SEED, UNCERTAIN, option
from vibrocap.cli.terminal import Page
from vibrocap.cli.texts import checked_pairs
from vibrocap.quantities.dimensional import in_si


class RobustRequest(OfCase):
    uncertain: list[str] = UNCERTAIN(REQUIRED)
    for_: str = FOR
    json: bool = JSON
    samples: int = option("a power of two", 256, advanced=True)
    seed: int = SEED


@command(
    "design",
    "vibrocap robust examples/travels-by-stick-slip.toml --uncertain machine.damping=0.9:1.1 "
    "--uncertain friction.coulomb_coefficient,friction.static_coefficient=factor:0.8:1.2 --samples 64",
    doing="Sampling the uncertain quantities",
)
def robust(request: RobustRequest, report: Report) -> Answer:
    """Spread of a measure under uncertain parameters.

    Samples of the uncertain quantities run until they settle. The report has the spread of the measure, its worst
    values, the share that fails or travels in the wrong direction, and Sobol indices: the quantity to measure better.
    """
    from vibrocap.design.robustness import robustness

    quantities = checked_pairs("uncertain", request.uncertain, "PATH=LOW:HIGH, such as machine.damping=0.9:1.1")
    settings = request.given("samples", "seed")
    result = robustness(request.setup, quantities, request.for_, progress=report, **settings)

    def text(page: Page) -> None:
        page.say(f"Robustness of {result.measure}", style="bold")
        page.rows(list(result.facts.items()), 16)
        if result.first_order and result.total:
            page.say("Sobol indices: alone, and with all that it takes part in")
            rows = ((name, result.first_order[name], result.total[name]) for name in result.total)
            width = max(16, 2 + max(map(len, result.total)))
            page.rows([(name, f"{alone[0]:.3f}, {total[0]:.3f}") for name, alone, total in rows], width)

    return Answer(in_si(result, request.setup.system), text)
