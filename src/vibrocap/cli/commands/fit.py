"""`vibrocap fit`: a friction law, several laws ranked, or a case (--machine), fitted to measured records."""

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.cli.command import Answer, Report, command
from vibrocap.cli.fit_request import FitRequest, own_settings, rig
from vibrocap.cli.options import own_names
from vibrocap.cli.terminal import complain, part
from vibrocap.cli.texts import checked_pairs
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si, view
from vibrocap.quantities.json_text import json_text

if TYPE_CHECKING:
    from vibrocap.design.calibration.motion_fit import MotionFit
    from vibrocap.identification.experiments.parameter_samples import Posterior
    from vibrocap.identification.fit_result import Chapter, Fit
    from vibrocap.records.record import Record

# what a case fitted to records writes into --out, and the columns of its table
FILES = ("motion-fit.json", "fitted.toml", "predicted.csv", "predicted.png", "report.html", "posterior.json")
COLUMNS = ("record", "held_out", "time", "measured", "predicted", "band")


@command(
    "data",
    "vibrocap fit damper.csv --law dahl --out fit --plot fit.png",
    "vibrocap fit damper.csv --compare coulomb,dahl --json",
    "vibrocap fit axis.csv --machine axis.toml --predict position --over machine.mass_kg=50:200",
    doing="Fitting",
)
def fit(request: FitRequest, report: Report) -> Answer:
    """A friction law fitted to measured force and motion.

    The report has the parameters with 95 % intervals, an experiment for each one that the data do not determine, and
    the error for each record; it ranks several laws. With --out, friction.toml is the section [friction] of a case in
    SI, or with --pendulum of a dimensionless case.

    With --machine the measured force is that of the drive: the fit finds the parameters with which the case moves as
    measured (--predict).

    Exit code 3: the law could not be fitted.
    """
    plan, _ = request.plan_and_complaints
    for doubt in plan.doubts:
        complain(f"warning: {doubt}")
    if request.machine is not None:
        return _machine(request, plan.records, plan.settings, report)
    settings = plan.settings | {"progress": report}
    return (_compared if request.compare else _fitted)(request, plan.records, settings, plan.scales)


def _fitted(request: FitRequest, records: "list[Record]", settings: dict[str, Any], scales: Any) -> Answer:
    from vibrocap.identification.fit import fit as driven_fit
    from vibrocap.identification.fit import steady_fit
    from vibrocap.identification.spring_fit import spring_fit

    method = spring_fit if request.spring is not None else steady_fit if request.steady else driven_fit
    choice = None
    if request.searches_terms:
        from vibrocap.identification.experiments.term_choice import choose_terms

        choice = choose_terms(records, request.laws[0], **{k: v for k, v in settings.items() if k != "terms"})
        settings = settings | {"terms": choice.terms}
    result = method(records, request.laws[0], **settings)
    if not result.ok:
        return Answer(result, incomplete=f"No fit of {request.laws[0]}: {result.status}.")
    record, more = _further(request, result)
    if choice is not None:
        record["terms"] = choice
        more.append(choice.chapter)
    written = _write(result, request.out, scales, request, more) if request.out is not None else []
    text = "\n".join([result.summary(), *("\n" + "\n".join(line.lines()) for line in more)])
    return Answer(record, text, result, written=tuple(("Written:", path) for path in written))


def _further(request: FitRequest, fitted: "Fit") -> "tuple[Any, list[Chapter]]":
    """What is asked beside a fit: the record with it, and it in words."""
    record, more = view(fitted), []
    if request.bootstrap is not None:
        from vibrocap.identification.experiments.parameter_samples import bootstrap

        record["bootstrap"] = scattered = bootstrap(fitted, replicates=request.bootstrap, seed=request.seed)
        more.append(scattered.chapter)
    if request.posterior is not None:
        record["posterior"] = drawn = _drawn(fitted, request)
        more.append(drawn.chapter)
    if request.design is not None:
        from vibrocap.identification.experiments.experiment_design import candidate_motions, experiment_design

        motions = candidate_motions(**rig("--design", request.design), unit=fitted.units.displacement)
        record["design"] = design = experiment_design(fitted, motions)
        more.append(design.chapter)
    return record, more


def _drawn(fitted: "Fit | MotionFit", request: FitRequest) -> "Posterior":
    """Samples of what a fit leaves uncertain, written into --out."""
    from vibrocap.identification.experiments.parameter_samples import posterior

    drawn = posterior(fitted, samples=request.posterior or 0, seed=request.seed)
    if request.out is not None:
        write_text(made_folder(request.out) / "posterior.json", json_text(view(drawn)) + "\n")
    return drawn


def _compared(request: FitRequest, records: "list[Record]", settings: dict[str, Any], scales: Any) -> Answer:
    from vibrocap.identification.experiments.comparison import compare

    own = {law: own_settings(law, settings) for law in request.laws}
    result = compare(records, request.laws, options=own, **settings)
    good, out = [law.fit for law in result.laws if law.fit.ok], request.out
    written = []
    if out is not None:
        for fitted in good:
            written += _write(fitted, made_folder(out / fitted.law_name, own=True), scales, request)
        text = json_text(result) + "\n"
        written.append(write_text(made_folder(out) / "comparison.json", text))
        if good and request.report:
            from vibrocap.report.results import write_comparison_page

            written += write_comparison_page(result, out, request.again())
        elif good and _can_draw():
            from vibrocap.plotting.fits import comparison_figure
            from vibrocap.plotting.look.finishing import save

            written.append(save(comparison_figure(result), out / "comparison.png"))
    incomplete = "" if good else f"None of the laws could be fitted: {result.laws[0].fit.status}."
    shown = tuple(("Written:", path) for path in written)
    return Answer(result, result.summary(), result if good else None, written=shown, incomplete=incomplete)


def _write(fitted: "Fit", folder: Path, scales: Any, request: FitRequest, more: "Sequence[Chapter]" = ()) -> list[Path]:
    written = list(fitted.save(folder, scales)) + [folder / "posterior.json"] * bool(request.posterior)
    written.append(write_residuals(fitted, folder / "residuals.csv"))
    if request.report:
        from vibrocap.report.results import write_fit_page

        written += write_fit_page(fitted, folder, request.again(), more)
    elif _can_draw():
        from vibrocap.plotting.fits import fit_figure, residual_figure
        from vibrocap.plotting.look.finishing import save

        written.append(save(fit_figure(fitted), folder / "fit.png"))
        written.append(save(residual_figure(fitted), folder / "residuals.png"))
    return written


def _can_draw() -> bool:
    return importlib.util.find_spec("matplotlib") is not None


def write_residuals(fitted: "Fit", path: Path) -> Path:
    """Every judged sample as a line of CSV: motion, force and what the fit makes of it, in SI units."""
    unit, speed = fitted.units.heading, fitted.units.velocity.replace("/", "_per_")
    forces = (f"measured_{unit}", f"fitted_{unit}", f"error_{unit}")
    rows = (
        (record.name, int(record.held_out), *(f"{value:.9g}" for value in row))
        for record in fitted.records
        for row in zip(
            *(record.time, record.velocity, record.measured, record.predicted, record.predicted - record.measured),
            strict=True,
        )
    )
    return write_table(path, ("record", "held_out", "time_s", f"velocity_{speed}", *forces), rows)


def _machine(request: FitRequest, records: "list[Record]", settings: dict[str, Any], report: Report) -> Answer:
    from vibrocap.design.calibration.motion_fit import fit_motion

    assert request.machine is not None
    ranges: dict[str, Any] = checked_pairs("over", request.over, "PATH=LEAST:LARGEST, such as machine.mass_kg=1:10")
    if request.out is not None:
        own_names("--out", request.out, *FILES)
    shared = ("held_out", "priors", "terms", "by_record", "along")
    settings = {name: settings[name] for name in shared if settings.get(name)} | {"progress": report}
    settings |= request.given("predict", "starts", "seed", "segments")
    result = fit_motion(read_source(request.machine), records, ranges, **settings)
    record, written, facts = view(in_si(result)), [], dict(result.facts)
    if request.posterior is not None:
        drawn = _drawn(result, request)
        record["posterior"] = view(drawn)
        facts |= {f"{name} (95 % of samples)": text for name, text in drawn.facts.items()}
    if request.out is not None:
        folder = made_folder(request.out)
        written += [folder / "posterior.json"] * bool(request.posterior)
        written.append(write_text(folder / FILES[0], json_text(in_si(result)) + "\n"))
        written.append(result.case().save(folder / FILES[1]))
        parts = result.time, result.measured, result.predicted, result.band
        samples = (
            (name, int(name in result.held_out), *(f"{value:.9g}" for value in row))
            for name in result.measured
            for row in zip(*(values[name] for values in parts), strict=True)
        )
        written.append(write_table(folder / FILES[2], COLUMNS, samples))
        if request.report:
            from vibrocap.report.results import write_motion_page

            written += write_motion_page(result, folder, request.again())

    text = part(f"{result.heading}, by {request.machine}", facts.items(), 2 + max(map(len, facts)))
    return Answer(record, text, result, written=tuple(("Written:", path) for path in written))
