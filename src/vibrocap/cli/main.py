"""The command line: `vibrocap reproduce`, `simulate`, `limits`, and `sweep`, `measures`, `plot` from their modules.

Exit codes: 0 done; 2 wrong input, each bad field named on stderr before any work; 3 a run that could not be completed,
with its status and what was computed until then; 130 interrupted.
"""

import io
import os
import re
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from cyclopts import App, CycloptsError, Parameter

from vibrocap.case import CaseError
from vibrocap.cli.branch import basins, branch
from vibrocap.cli.crossing import crossing
from vibrocap.cli.datasets import datasets
from vibrocap.cli.exits import BROKEN_PIPE, INCOMPLETE, INTERRUPTED, OK, WRONG_INPUT, complain
from vibrocap.cli.fit import fit
from vibrocap.cli.friction import friction
from vibrocap.cli.orbit import orbit
from vibrocap.cli.plot import plot
from vibrocap.cli.stick_slip import stick_slip
from vibrocap.cli.sweep import measures, sweep
from vibrocap.cli.terminal import PICTURES, Refusal, needs, needs_film, progress, writable_file, writable_folder

EXPORTS = (".nc", ".csv")
ANIMATIONS = (".mp4", ".gif")

EXAMPLES = """Examples:

  vibrocap reproduce --only fig09
  vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png
  vibrocap simulate examples/bristles-lugre.toml --json --out run.nc
  vibrocap limits examples/bristles-lugre.toml
  vibrocap sweep examples/travels-by-stick-slip.toml --over drive.amplitude=1:3:40 --out map
  vibrocap plot map --measure mean_velocity --out map.png
  vibrocap orbit examples/travels-by-stick-slip.toml
  vibrocap friction test lugre --plot tests.png

`vibrocap COMMAND --help` explains a command. Exit codes: 0 done, 2 wrong input, 3 a run that could not be completed.
"""

app = App(
    name="vibrocap",
    help="Vibro-driven capsules: machines that travel by shaking an inner mass against friction.",
    help_epilogue=EXAMPLES,
    help_format="plaintext",
    version=lambda: version("vibrocap"),
    result_action="return_value",
    default_parameter=Parameter(negative=()),
    suppress_keyboard_interrupt=False,  # `main` says what was interrupted
)


app.command(sweep)
app.command(measures)
app.command(plot)
app.command(orbit)
app.command(branch)
app.command(basins)
app.command(crossing)
app.command(friction)
app.command(fit)
app.command(stick_slip)
app.command(datasets)


@app.command
def reproduce(*, out: Path = Path("out"), only: str | None = None) -> int:
    """The paper: its figures from our own runs, its claims with their verdicts, one HTML report.

    Example: vibrocap reproduce --out out --only fig09

    Parameters
    ----------
    out
        folder for report.html, the figures and their data; made where it is missing
    only
        one figure and its claims, such as fig09
    """
    from vibrocap.paper.figures import KEYS

    if only is not None and only not in KEYS:
        raise Refusal(f"--only: should be one of {', '.join(KEYS)}, got {only!r}")
    needs("reproduce", "plot", "matplotlib")
    writable_folder("--out", out)
    from vibrocap.cli.summary import print_claims
    from vibrocap.report.reproduce import reproduce as reproduced

    with progress("The paper") as report:
        result = reproduced(out, only, lambda what, share: report(share, what))
    print_claims(result)
    return OK


@app.command
def simulate(
    case: Path,
    /,
    *,
    json: bool = False,
    out: Path | None = None,
    plot: Path | None = None,
    animate: Path | None = None,
    periods: float | None = None,
    tolerance: float | None = None,
) -> int:
    """One motion: how it ends, how far it travels, its events, energy and certificate.

    Example: vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png --out run.nc

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv), which is run again
    json
        print one JSON object in full precision instead of tables
    out
        export the motion, with its case, to FILE.nc (NetCDF) or FILE.csv
    plot
        draw time histories, phase planes and the friction loop: FILE.png, .svg or .pdf
    animate
        film the last periods: FILE.mp4 (needs ffmpeg) or FILE.gif
    periods
        drive periods to run, instead of the case's
    tolerance
        error per step relative to the states' natural size, instead of the case's
    """
    from vibrocap.cli.summary import print_motion
    from vibrocap.io import motion_file as export
    from vibrocap.io.record import json_text, motion_record

    settings = {name: value for name, value in (("periods", periods), ("tolerance", tolerance)) if value is not None}
    refused = _refused_destinations(out, plot, animate)
    try:
        setup = export.read_source(case, **settings)
    except CaseError as error:
        by_option = [re.sub(rf"^run\.({'|'.join(settings)}):", r"--\1:", text) for text in error.complaints]
        raise CaseError([*(by_option if settings else error.complaints), *refused], error.source) from None
    if animate is not None and "angle" not in setup.system.state_names:
        refused.append(f"--animate: draws the pendulum capsule only, not the machine {setup.system.machine.name!r}")
    if refused:
        raise Refusal("\n".join(refused))
    for path in (out, plot, animate):
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
    with progress("Simulating") as report:
        motion = setup.simulate(lambda share: report(share, None))
        record = motion_record(motion)
    if out is not None:
        export.write_motion(motion, setup, out)
    moved = len(motion.piece_start) > 0
    if plot is not None and moved:
        from vibrocap.plotting.motion import plot_motion

        plot_motion(motion, plot)
    if animate is not None and moved:
        from vibrocap.plotting.animation import animate_motion

        with progress("Filming") as report:
            animate_motion(motion, animate, progress=lambda share: report(share, None))
    if json:
        print(json_text(record))
    else:
        print_motion(motion, record, str(case))
    if motion.status.ok:
        return OK
    complain(
        f"The run could not be completed ({motion.status.value}): it stopped at time {motion.end:.10g} of "
        f"{motion.periods * motion.period:.10g}.\n{motion.status.text}"
        + ("" if moved or not (plot or animate) else "\nThere is nothing to draw.")
    )
    return INCOMPLETE


@app.command
def limits(case: Path, /, *, json: bool = False) -> int:
    """Frictional limits of a case (the paper's eqs 10-15): exact, as printed, and why where they do not exist.

    Example: vibrocap limits examples/bristles-lugre.toml

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    json
        print one JSON object in full precision instead of tables
    """
    import dataclasses

    from vibrocap.cli.summary import print_limits
    from vibrocap.io.motion_file import read_source
    from vibrocap.io.record import json_text
    from vibrocap.measures.limits import frictional_limits

    system = read_source(case).system
    try:
        found = frictional_limits(system.friction, float(system.machine.load()))
    except (TypeError, ValueError) as error:
        raise CaseError([f"friction: {error}"], str(case)) from None
    if json:
        print(json_text(dataclasses.asdict(found)))
    else:
        print_limits(found, system.friction)
    return OK


def _refused_destinations(out: Path | None, plot: Path | None, animate: Path | None) -> list[str]:
    """What could not be written, and why; found before any work."""
    refused = []
    wanted = (("--out", out, EXPORTS), ("--plot", plot, PICTURES), ("--animate", animate, ANIMATIONS))
    for option, path, kinds in wanted:
        if path is None:
            continue
        try:
            writable_file(option, path, kinds)
            if option != "--out":
                needs(option, "plot", "matplotlib")
            elif path.suffix.lower() == ".nc":
                needs(option, "export", "xarray", "h5netcdf")
            if option == "--animate":
                needs_film(option, path)
        except Refusal as refusal:
            refused.append(str(refusal))
    return refused


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns its exit code."""
    for stream in (sys.stdout, sys.stderr):  # a terminal without Greek letters still gets the numbers
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        return int(app(arguments, exit_on_error=False, print_error=False) or OK)
    except CaseError as error:
        complain(str(error))
    except Refusal as error:
        complain(str(error))
    except CycloptsError as error:
        complain(f"{error}\nvibrocap --help shows the commands with an example each.")
    except BrokenPipeError:  # the reader of a pipe, `head` for instance, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except KeyboardInterrupt as interruption:
        complain(str(interruption) or "Interrupted.")
        return INTERRUPTED
    return WRONG_INPUT


if __name__ == "__main__":
    sys.exit(main())
