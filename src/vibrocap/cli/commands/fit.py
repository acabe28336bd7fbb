"""`vibrocap fit`: the parameters of a friction law from measured records, or several laws ranked on them."""

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import Complaints
from vibrocap.cli.commands.fit_request import (
    by_option,
    held_out,
    held_parameters,
    is_refusal,
    machine_stiffness,
    own_settings,
    read,
    units_of_case,
)
from vibrocap.cli.options import Refusal, own_names, split, writable_folder, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.quantities.json_text import json_text

if TYPE_CHECKING:
    from vibrocap.identification.result.fit_result import Fit
    from vibrocap.records.record import Record

OF_FIT = ("fit.json", "friction.toml", "residuals.csv", "fit.png", "residuals.png")  # what a fit writes into --out


def fit(
    *data: Path,
    law: str | None = None,
    compare: list[str] | None = None,
    machine: Path | None = None,
    predict: str = "position",
    over: list[str] | None = None,
    columns: list[str] | None = None,
    units: list[str] | None = None,
    sampling_rate: float | None = None,
    load: float | None = None,
    cutoff: float | None = None,
    fixed: list[str] | None = None,
    free: list[str] | None = None,
    hold_out: list[str] | None = None,
    offset: bool = False,
    mass: bool = False,
    delay: bool = False,
    steady: bool = False,
    spring: str | None = None,
    least_speed: float = 0.0,
    loss: str = "linear",
    weights: str = "power",
    start: str = "fitted",
    intervals: str | None = None,
    starts: int = 8,
    seed: int = 0,
    out: Path | None = None,
    pendulum: list[str] | None = None,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """Fit a friction law to measured force and motion, or rank several laws on them.

    It prints the parameters with 95 % intervals, which of them the data do not
    determine and which experiment would, and the error for each record. With --out
    it writes friction.toml, the section [friction] of a case in SI, or with
    --pendulum of a dimensionless case.

    With --machine the force is that of the drive: the case is simulated under it,
    and its parameters are those with which it moves as measured (--predict).

    Exit codes: 0 done, 2 wrong input, 3 the law could not be fitted.

    Parameters
    ----------
    data
        FILE.csv, .txt, .npz or .mat, one or several: force with velocity, displacement or both
    law
        a law, as `vibrocap friction list` shows them
    compare
        LAW,LAW,... instead of --law: fit each, and rank them by their error on data that they were not fitted to
    machine
        a case instead of --law: machine and law together, fitted to the motion that it makes under the measured force
    predict
        of --machine: the quantity of its motion that is compared with the measured one, such as angle or velocity
    over
        of --machine: PATH=LEAST:LARGEST, what is unknown and within which bounds; once for each parameter
    columns
        QUANTITY=NAME, such as force=F1,velocity=v, if the columns have unusual names
    units
        QUANTITY=UNIT, such as force=kN,displacement=mm, if the headings do not say
    sampling_rate
        samples per second (Hz), if there is no column of time
    load
        normal force in N; without it, and without such a column, coefficients are forces in N
    cutoff
        cut-off of the low-pass filter of the motion in Hz [default: no filter]
    fixed
        NAME=VALUE, a parameter that is not fitted; may be repeated
    free
        NAME,NAME,... the parameters that are fitted [default: all but those fixed by convention]
    hold_out
        RECORD,RECORD,... that are predicted and not fitted; eq_* stands for all that begin with eq_
    offset
        fit a constant error of the force sensor too
    mass
        fit the inertia between sensor and contact too
    delay
        fit the time by which the force is late behind the motion too
    steady
        fit only the curve of force over velocity, without the memory of the contact
    spring
        of rate-and-state laws: stiffness of the machine in N/m, or measured (from the data), or searched (fitted)
    least_speed
        slowest samples that --steady takes, in m/s
    loss
        linear, soft_l1, huber, cauchy or arctan; all but the first give outliers less weight
    weights
        power: records count alike, whatever the size of their forces; equal: all samples have the same noise
    start
        the contact at the first sample: fitted, or relaxed
    intervals
        profile (of the likelihood), or covariance, which is quicker [default: profile; with --compare covariance]
    starts
        number of searches from different starting points
    seed
        seed of the starting points
    out
        folder for fit.json, friction.toml, residuals.csv and pictures; with --compare one in it for each law
    pendulum
        mass=KG,length=M of the pendulum whose weight and length are the units of the case
    plot
        draw measured and fitted force, loops and intervals: FILE.png, .svg or .pdf
    json
        print one JSON object in full precision
    """
    complaints = Complaints()
    laws = split([law]) if law else split(compare)
    held = held_parameters(laws, fixed, free, complaints)
    if machine is not None and (law or compare or steady or spring):
        complaints.append("--machine: has its own law: give it without --law, --compare, --steady and --spring")
    elif machine is None and bool(law) == bool(compare):
        complaints.append("--law: give one law, or several with --compare, or a case with --machine")
    if compare and steady:
        complaints.append("--steady: is for --law; laws are compared by driving them through the records")
    stiffness = machine_stiffness(spring, compare or steady, hold_out, data, complaints)
    if not data:
        complaints.append("DATA: give at least one file with force and motion")
    with complaints.collected():
        if out is not None:
            writable_folder("--out", out)
            if compare:
                own_names("--out", out, "comparison.json", "comparison.png")
            for folder in [out / each for each in laws] if compare else [out]:
                own_names("--out", folder, *OF_FIT)
    with complaints.collected():
        writable_picture("--plot", plot)
    found, doubts = read(data, columns, units, sampling_rate, load, cutoff, complaints)
    hidden = held_out(hold_out, found, complaints)
    scales = units_of_case(pendulum, out, found, complaints)
    if complaints:
        raise Refusal(*complaints)
    for doubt in doubts:
        complain(f"warning: {doubt}")
    if machine is not None:
        from vibrocap.cli.commands.fit_motion import fit_machine

        how = {"starts": starts, "seed": seed}
        return fit_machine(machine, found, over, predict, hidden, how, out, plot, json)
    settings: dict[str, Any] = {"fixed": held, "free": split(free) or None, "held_out": hidden, "loss": loss}
    settings |= {"starts": starts, "seed": seed} | ({} if intervals is None else {"intervals": intervals})
    if spring is not None:
        del settings["held_out"]
        settings |= {"machine_stiffness": stiffness}
    else:
        settings |= {"weights": weights, "offset": offset}
        settings |= {"least_speed": least_speed} if steady else {"mass": mass, "delay": delay, "start": start}
    try:
        if compare:
            return _compared(found, laws, settings, out, scales, plot, json)
        method = "spring" if spring is not None else "steady" if steady else "driven"
        return _fitted(found, laws[0], method, settings, out, scales, plot, json)
    except ValueError as error:
        if not is_refusal(str(error)):  # a fault of ours, which must not pass for one of the user's
            raise
        raise Refusal(by_option(str(error))) from None


def _fitted(
    records: "list[Record]",
    law: str,
    method: str,
    settings: dict[str, Any],
    out: Any,
    scales: Any,
    plot: Any,
    json: bool,
) -> int:
    from vibrocap.identification.fitting.fit import fit as driven_fit
    from vibrocap.identification.fitting.spring_fit import spring_fit
    from vibrocap.identification.fitting.steady_fit import steady_fit

    methods = {"driven": driven_fit, "steady": steady_fit, "spring": spring_fit}
    with progress(f"Fitting {law}") as report:
        found = methods[method](records, law, progress=report, **settings)
    if not found.ok:
        if json:
            print(json_text(found))
        complain(f"No fit of {law}: {found.status}.")
        return INCOMPLETE
    written = _write(found, out, scales) if out is not None else []
    if plot is not None:
        from vibrocap.plotting.fits import fit_figure
        from vibrocap.plotting.look.finishing import save

        written.append(save(fit_figure(found), plot))
    if json:
        print(json_text(found))
        return OK
    page = Page()
    page.say(found.summary())
    _print_written(page, written)
    return OK


def _compared(
    records: "list[Record]", laws: list[str], settings: dict[str, Any], out: Any, scales: Any, plot: Any, json: bool
) -> int:
    from vibrocap.identification.experiments.comparison import compare

    with progress(f"Fitting {len(laws)} laws") as report:
        own = {law: own_settings(law, settings) for law in laws}
        found = compare(records, laws, options=own, progress=report, **settings)
    good = [each.fit for each in found.laws if each.fit.ok]
    written = (
        [path for each in good for path in _write(each, made_folder(out / each.law_name, own=True), scales)]
        if out is not None
        else []
    )
    if out is not None:
        text = json_text(found) + "\n"
        written.append(write_text(made_folder(out) / "comparison.json", text))
    pictures = [plot] if plot is not None else []
    pictures += [out / "comparison.png"] if out is not None and _can_draw() else []
    for picture in pictures if good else ():
        from vibrocap.plotting.fits import comparison_figure
        from vibrocap.plotting.look.finishing import save

        written.append(save(comparison_figure(found), picture))
    if json:
        print(json_text(found))
    else:
        page = Page()
        page.say(found.summary())
        _print_written(page, written)
    if not good:
        complain(f"None of the laws could be fitted: {found.laws[0].fit.status}.")
        return INCOMPLETE
    return OK


def _write(found: "Fit", folder: Path, scales: Any) -> list[Path]:
    """The files of a fit in a folder."""
    written = list(found.save(folder, scales))
    written.append(write_residuals(found, folder / "residuals.csv"))
    if _can_draw():
        from vibrocap.plotting.fits import fit_figure, residual_figure
        from vibrocap.plotting.look.finishing import save

        written.append(save(fit_figure(found), folder / "fit.png"))
        written.append(save(residual_figure(found), folder / "residuals.png"))
    return written


def _can_draw() -> bool:
    return importlib.util.find_spec("matplotlib") is not None


def _print_written(page: Page, written: list[Path]) -> None:
    for path in written:
        page.say(f"Written: {path}")


def write_residuals(found: "Fit", path: Path) -> Path:
    """Every sample of every record as a line of CSV: motion, force and what the fit makes of it, in SI units."""
    unit, speed = found.units.heading, found.units.velocity.replace("/", "_per_")
    forces = (f"measured_{unit}", f"fitted_{unit}", f"error_{unit}")
    rows = (
        (each.name, int(each.held_out), *(f"{value:.9g}" for value in row))
        for each in found.records
        for row in zip(
            each.time, each.velocity, each.measured, each.predicted, each.predicted - each.measured, strict=True
        )
    )
    return write_table(path, ("record", "held_out", "time_s", f"velocity_{speed}", *forces), rows)
