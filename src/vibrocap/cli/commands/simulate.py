"""`vibrocap simulate`: one motion of a case."""

import functools
from pathlib import Path
from typing import Any, Literal

from vibrocap.arguments import Complaints, Refusal, by_option
from vibrocap.case.case import Case, CaseError
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.completers import paths_of_case, states_of_case
from vibrocap.cli.destinations import with_headings, writable_film, writable_table
from vibrocap.cli.motion_tables import print_motion
from vibrocap.cli.options import JSON, TOLERANCE, option, picture
from vibrocap.cli.terminal import progress, said
from vibrocap.cli.texts import changes, split
from vibrocap.io.motion_file import read_source, write_motion
from vibrocap.quantities.dimensional import computed, in_si, view


class SimulateRequest(OfCase, Drawn):
    out: Path | None = option(
        "export the motion, with its case, to FILE.nc (NetCDF), FILE.csv, FILE.xlsx (Excel) or FILE.mat (MATLAB)",
        check=lambda name, path: writable_table(name, path, "xarray"),
    )
    plot: Path | None = picture("time histories, phase planes and the friction loop")
    animate: Path | None = option(
        "a film of the last periods: FILE.mp4 (needs ffmpeg) or FILE.gif", check=writable_film
    )
    set_: list[str] | None = option(
        "PATH=VALUE in place of the case's, such as machine.mass_ratio=2 or friction.law=lugre; may be repeated",
        offers=paths_of_case,
    )
    initial: list[str] | None = option(
        "NAME=VALUE in place of the case's initial condition, such as angle=0.5; may be repeated", offers=states_of_case
    )
    periods: float | None = option("drive periods to run [default: the case's]")
    json: bool = JSON
    cite: Literal["text", "bibtex"] | None = option("print the works to cite for the case, instead of a motion")
    tolerance: float | None = TOLERANCE()
    unit_headings: bool = option(
        'name and unit in the headings of .csv and .xlsx, as in "position [m]"', False, advanced=True
    )
    analyses: list[str] | None = option(
        "with --cite, commands that were used too, such as orbit,fit", needs="cite", advanced=True
    )

    @functools.cached_property
    def changes(self) -> tuple[dict[str, tuple[str, Any]], Complaints]:
        """The values that the options replace in the case, by path with the option, and complaints about them."""
        refused = Complaints()
        changed = changes(self.set_, self.initial, refused)
        settings = self.given("periods", "tolerance")
        return changed | {f"run.{name}": (f"--{name}", value) for name, value in settings.items()}, refused

    @functools.cached_property
    def setup(self) -> Case:
        """The case with the values that the options replace."""
        changed, refused = self.changes
        try:
            setup = read_source(self.case, {path: value for path, (_, value) in changed.items()})
        except CaseError as error:
            named = by_option(error.complaints, {path: option for path, (option, _) in changed.items()})
            raise CaseError([*named, *refused], error.source) from None
        if refused:
            raise Refusal(*refused)
        return setup

    def plan(self, refused: Complaints) -> None:
        """Units stand in headings of files that have some."""
        with_headings(self.out, self.unit_headings, "--out")


@command(
    "run",
    "vibrocap simulate case.toml --initial angle=0.5",
    "vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png",
    "vibrocap simulate examples/bristles-lugre.toml --json --out run.nc",
    "vibrocap simulate run.nc --set machine.mass_ratio=1.5 --periods 20",
    "vibrocap simulate examples/bristles-lugre.toml --cite bibtex --analyses orbit,fit",
    doing="Simulating",
)
def simulate(request: SimulateRequest, report: Report) -> Answer:
    """One motion: travel, events, energy and certificate.

    It shows how the run ends, how far it travels, its events, energy balance and certificate.

    Exit code 3: the run could not be completed, or its certificate failed.
    """
    from vibrocap.measures.recorded.summary import motion_summary

    setup = request.setup
    if request.cite is not None:
        from vibrocap.citations.cite import cite

        works = cite(setup, analyses=split(request.analyses))
        return Answer({"cite": str(works)}, str(works) if request.cite == "text" else works.bibtex.rstrip())
    motion = setup.simulate(report)
    record: dict[str, Any] = {}
    for name, each in view(in_si(motion_summary(computed(motion)), motion.system)).items():
        record |= each if name == "sticking" else {name: each}
    if request.out is not None:
        write_motion(motion, request.out, setup, unit_headings=request.unit_headings)
    moved = len(motion.piece_start) > 0
    if request.animate is not None and moved:
        from vibrocap.plotting.animation import animate_motion

        with progress("Filming") as share:
            animate_motion(computed(motion), request.animate, progress=share)
    incomplete = ""
    if not motion.status.ok and motion.run_status.ok:
        incomplete = "\n".join([motion.status.text, *motion.certificate.failures])
    elif not motion.status.ok:
        end = said(motion.periods * motion.period, motion.unit_of("period"))
        state = f", {motion.facts['end']}" if "last state" in motion.status.text else ""
        where = f"it stopped at time {motion.said('end')} of {end}{state}.\n{motion.status.text}"
        incomplete = f"The run could not be completed ({motion.status.value}): {where}"
        incomplete += "" if moved or not (request.plot or request.animate) else "\nThere is nothing to draw."
    drawn = computed(motion) if moved else None
    title = str(request.case)
    return Answer(record, lambda page: print_motion(page, motion, record, title), drawn, incomplete=incomplete)
