"""`vibrocap simulate`: one motion of a case."""

import collections
import dataclasses
import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from vibrocap.arguments import Complaints
from vibrocap.case.case import Case, CaseError
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.completers import states_of_case
from vibrocap.cli.destinations import with_headings, writable_film, writable_table
from vibrocap.cli.motion_tables import further_events, own_events, print_motion
from vibrocap.cli.options import Json, Option, Settings, Tolerance, picture
from vibrocap.cli.refusal import Refusal, by_option
from vibrocap.cli.terminal import progress, said
from vibrocap.cli.texts import changes, split
from vibrocap.io.json_text import in_both, plain
from vibrocap.io.motion_file import read_source, write_motion
from vibrocap.physics import events
from vibrocap.quantities.dimensional import computed, units_of
from vibrocap.quantities.opening import opened_in_si

if TYPE_CHECKING:
    from vibrocap.measures.recorded.energy import EnergyBalance
    from vibrocap.measures.recorded.travel import MeanVelocity
    from vibrocap.motion.trajectory import Trajectory


@dataclasses.dataclass(frozen=True, kw_only=True)
class SimulateRequest(OfCase, Drawn):
    """The options of `vibrocap simulate`."""

    out: Annotated[
        Path | None,
        Option(
            "export the motion, with its case, to FILE.nc (NetCDF), FILE.csv, FILE.xlsx (Excel) or FILE.mat (MATLAB)",
            check=lambda name, path: writable_table(name, path, "xarray"),
        ),
    ] = None
    plot: Annotated[Path | None, picture("time histories, phase planes and the friction loop")] = None
    animate: Annotated[
        Path | None, Option("a film of the last periods: FILE.mp4 (needs ffmpeg) or FILE.gif", check=writable_film)
    ] = None
    set_: Settings = None
    initial: Annotated[
        list[str] | None,
        Option(
            "NAME=VALUE in place of the case's initial condition, such as angle=0.5; may be repeated",
            offers=states_of_case,
        ),
    ] = None
    periods: Annotated[float | None, Option("drive periods to run [default: the case's]")] = None
    json: Json = False
    cite: Annotated[
        Literal["text", "bibtex"] | None, Option("print the works to cite for the case, instead of a motion")
    ] = None
    tolerance: Annotated[float | None, Tolerance] = None
    unit_headings: Annotated[
        bool, Option('name and unit in the headings of .csv and .xlsx, as in "position [m]"', advanced=True)
    ] = False
    analyses: Annotated[
        list[str] | None,
        Option("with --cite, commands that were used too, such as orbit,fit", needs="cite", advanced=True),
    ] = None

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
    setup = request.setup
    if request.cite is not None:
        from vibrocap.citations.cite import cite

        works = cite(setup, analyses=split(request.analyses))
        return Answer({"cite": str(works)}, str(works) if request.cite == "text" else works.bibtex.rstrip())
    motion = setup.simulate(report)
    record = motion_record(motion)
    if request.out is not None:
        write_motion(motion, request.out, setup, unit_headings=request.unit_headings)
    moved = len(motion.piece_start) > 0
    if request.animate is not None and moved:
        from vibrocap.plotting.animation import animate_motion

        with progress("Filming") as share:
            animate_motion(computed(motion), request.animate, progress=share)

    def figure() -> Any:
        from vibrocap.plotting.motion import motion_figure

        return motion_figure(computed(motion))

    incomplete = ""
    if not motion.status.ok and motion.run_status.ok:
        incomplete = "\n".join([motion.status.text, *motion.certificate.failures])
    elif not motion.status.ok:
        end = said(motion.periods * motion.period, motion.unit_of("period"))
        where = f"it stopped at time {motion.said('end')} of {end}.\n{motion.status.text}"
        incomplete = f"The run could not be completed ({motion.status.value}): {where}"
        incomplete += "" if moved or not (request.plot or request.animate) else "\nThere is nothing to draw."
    return Answer(
        record,
        lambda page: print_motion(page, motion, record, str(request.case)),
        figure if moved else None,
        incomplete=incomplete,
    )


def motion_record(motion: "Trajectory") -> dict[str, Any]:
    """The measures of a motion by name; None where there is none (no whole period yet, no travel, no sticking)."""
    from vibrocap.measures.recorded import energy, sticking, travel
    from vibrocap.measures.recorded.windows import whole_periods

    energy_balance, stick_fraction = opened_in_si(energy.energy_balance), opened_in_si(sticking.stick_fraction)
    drift, mean_velocity = opened_in_si(travel.drift), opened_in_si(travel.mean_velocity)
    whole = max(0, whole_periods(computed(motion)))
    started = len(motion.piece_start) > 0
    travels = whole > 0 and motion.system.cyclic is not None
    velocity = mean_velocity(motion) if travels else None
    nothing = {"value": None, "window": None, "settled": False}
    counts = collections.Counter(motion.event_kinds)
    certificate = motion.certificate.record() if started else None
    least = certificate["least_reaction"] if certificate else None  # of the motion as it was computed, without units
    balance = energy_balance(motion) if started else None
    absent = {"drag", "outer_force", "gravity", "controller"}.difference(motion.system.channels)
    absent |= {"drive"} if "controller" in motion.system.channels else set()
    works = {} if balance is None else {**dataclasses.asdict(balance), **balance.own}
    works = {name: value for name, value in works.items() if name not in {"own", *absent}}
    turns = {"winding": travel.winding(computed(motion)) if whole > 0 else None} if motion.system.turns else {}
    record = plain(
        {
            "state": motion.state,
            "time": motion.end,
            "drift": drift(motion) if travels else None,
            "mean_velocity": nothing if velocity is None else dataclasses.asdict(velocity),
            "cost_of_transport": None if velocity is None else _cost_of_transport(motion, velocity),
            **turns,
            "events": {kind: counts[kind] for kind in (*events.MEANINGS, *own_events(motion), *further_events(motion))},
            "stick_fraction": stick_fraction(motion) if started else None,
            "least_reaction": None if least is None else least * motion.system.result_units.factor("friction"),
            "energy": works or None,
            "certificate": certificate,
            "status": motion.status.value,
        }
    )
    if motion.si_context() is None:
        return record
    units = {
        "state": {name: motion.unit_of(name) for name in motion.state},
        "time": motion.unit_of("end"),
        "drift": motion.unit_of("displacement"),
        "cost_of_transport": motion.system.si.of_contact("J/m"),
        "least_reaction": motion.system.si.unit("reaction"),
        "mean_velocity": {} if velocity is None else units_of(velocity),
        "energy": {} if balance is None else _units_of_works(balance, works),
    }
    return in_both(record, units, motion_record(computed(motion)))


def _units_of_works(balance: "EnergyBalance", works: dict[str, Any]) -> dict[str, str]:
    units = units_of(balance)
    return {name: unit for name, unit in (units | units.pop("own", {})).items() if name in works}


def _cost_of_transport(motion: "Trajectory", velocity: "MeanVelocity") -> float | None:
    """Work of the drive per distance travelled, in the window of the mean velocity; None for what cannot travel."""
    from vibrocap.measures.recorded.energy import energy_balance
    from vibrocap.measures.recorded.response import response_class
    from vibrocap.measures.recorded.windows import usual_window, whole_periods

    plain = computed(motion)
    if velocity.value == 0.0 or response_class(plain).symmetric:
        return None
    balance = opened_in_si(energy_balance)(motion, periods=usual_window(whole_periods(plain)))
    start, end = balance.window
    return (balance.drive + balance.controller) / abs(velocity.value * (end - start))
