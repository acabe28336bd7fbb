"""`vibrocap orbit` and `vibrocap crossing`: the steady motion of a case, and where a measure of it takes a value."""

from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case import CaseError
from vibrocap.faces.exits import INCOMPLETE, OK, complain
from vibrocap.faces.terminal import Page, Refusal, progress


def orbit(
    case: Path,
    /,
    *,
    response_period: int | None = None,
    half: bool = False,
    settle_periods: int = 2000,
    tolerance: float = 1e-12,
    json: bool = False,
) -> int:
    """The steady motion of a case: period, drift, stability, symmetry, mirror twin and word.

    Example: vibrocap orbit examples/travels-by-stick-slip.toml

    The motion is simulated from the case's start until it settles, then closed by
    shooting; what is printed holds to rounding. Exit code 3 where it does not
    settle or close.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    response_period
        look for an orbit of so many drive periods straight from the case's start, without simulating
    half
        look for a symmetric orbit, stable or not, straight from the case's start
    settle_periods
        most drive periods simulated
    tolerance
        of the runs, error per step over the natural size of each state
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.faces.export import read_source
    from vibrocap.faces.record import json_text
    from vibrocap.orbits.orbit import OrbitStatus
    from vibrocap.orbits.steady import orbit as steady_motion

    given = read_source(case)
    try:
        with progress("Closing the steady motion"):
            found = steady_motion(
                given.system,
                initial=given.initial,
                response_period=response_period,
                half=half,
                settle_periods=settle_periods,
                tolerance=tolerance,
            )
    except ValueError as error:
        raise CaseError([str(error)], str(case)) from None
    record = orbit_record(found)
    if json:
        print(json_text(record))
    else:
        _print_orbit(record, str(case))
    if found.status is OrbitStatus.CONVERGED:
        return OK
    complain(f"No closed steady motion ({found.status.value}). {found.status.advice}")
    return INCOMPLETE


def crossing(
    case: Path,
    /,
    *,
    over: str,
    measure: str = "drift",
    value: float = 0.0,
    against: str | None = None,
    points: int = 200,
    periods: int = 2000,
    json: bool = False,
) -> int:
    """Where a steady measure takes a value, or agrees with that of another law, over a parameter.

    Example: vibrocap crossing examples/buckled-pendulum-travels.toml --over machine.mass_ratio=0.2:8.1

    Each place comes with a bracket and an error. Where the measure equals the value
    over a whole range (the drift of symmetric motions is zero) or jumps over it
    (from a motion to its mirror twin), that is said instead. Exit code 3 where
    motions did not settle, so that places may be missing.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        PATH=LEAST:LARGEST, such as machine.mass_ratio=0.2:8.1
    measure
        a measure that is a number, see `vibrocap measures`
    value
        that is looked for
    against
        friction.law=NAME or PATH=VALUE: look for where the measures of the case and of the case so changed differ by
        the value (zero: agree). Another law takes over the parameters that both laws have
    points
        parameters of the scan that brackets the places
    periods
        drive periods in which a motion of the scan must settle
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.faces.export import read_source
    from vibrocap.faces.record import json_text
    from vibrocap.orbits.crossing import CrossingKind
    from vibrocap.orbits.crossing import crossing as crossings

    given = read_source(case)
    path, low, high = range_of(over)
    other = None if against is None else _other(given.system, against)
    try:
        with progress(f"Looking for {measure} = {value:g}") as report:
            found = crossings(
                given.system,
                measure,
                path,
                (low, high),
                value=value,
                against=other,
                initial=given.initial,
                points=points,
                periods=periods,
                progress=lambda share: report(share, None),
            )
    except ValueError as error:
        raise Refusal(str(error)) from None
    if json:
        print(json_text(_crossings_record(found)))
    else:
        page = Page()
        wanted = f"{found.measure} = {found.value:g}"
        if against is not None:
            wanted = f"{found.measure} less that with {against} = {found.value:g}"
        page.print(f"{wanted} over {found.over}", style="bold", soft_wrap=True)
        for line in str(found).splitlines():
            page.print(f"  {line}", soft_wrap=True, markup=False)
    lost = [each for each in found.found if each.kind is CrossingKind.LOST]
    if found.unsettled or lost:
        many = f"{len(found.unsettled)} of {len(found.parameters)} motions of the scan did not settle"
        what = many if found.unsettled else CrossingKind.LOST.advice
        complain(f"Places may be missing: {what}. Raise --periods, or narrow the range; such motions may be chaotic.")
        return INCOMPLETE
    return OK


def _crossings_record(found: Any) -> dict[str, Any]:
    """What was found and what the scan saw, by name; NaN where a motion did not settle is null."""
    import dataclasses

    return {
        "measure": found.measure,
        "over": found.over,
        "value": found.value,
        "found": [dataclasses.asdict(each) | {"kind": each.kind.value} for each in found.found],
        "equal": found.equal,
        "unsettled": found.unsettled,
        "parameters": found.parameters.tolist(),
        "differences": found.differences.tolist(),
    }


def orbit_record(found: Any) -> dict[str, Any]:
    """What is known of an orbit, by name."""
    from vibrocap.orbits.orbit import OrbitStatus

    closed = found.status is OrbitStatus.CONVERGED
    twin = None
    if closed and found.mirrored_state is not None and not found.symmetric:
        twin = {"state": found.mirrored_state, "drift": None if found.drift is None else -found.drift}
    return {
        "status": found.status.value,
        "residual": found.residual,
        "period": found.period,
        "response_period": found.response_period,
        "drift": found.drift,
        "mean_velocity": found.mean_velocity if found.period else None,
        "stable": found.stable if closed else None,
        "multipliers": [{"real": float(np.real(m)), "imaginary": float(np.imag(m))} for m in found.multipliers],
        "symmetric": found.symmetric,
        "word": found.word if closed else None,
        "state": found.state,
        "twin": twin,
    }


def _print_orbit(record: dict[str, Any], title: str) -> None:
    """The table of an orbit."""
    page = Page()
    page.print(f"Steady motion of {title}", style="bold", soft_wrap=True)
    periods = f" ({record['response_period']} of the drive)" if record["response_period"] else " (its own)"
    sizes = ", ".join(_multiplier(m) for m in record["multipliers"])
    symmetric = {True: "its own mirror image", False: "not symmetric", None: "the system has no such symmetry"}
    rows = [
        ("status", f"{record['status']}, residual {record['residual']:.2g}"),
        ("period", f"{record['period']:.12g}{periods}"),
        ("drift", "none" if record["drift"] is None else f"{record['drift']:.12g} per period"),
        ("mean velocity", "none" if record["mean_velocity"] is None else f"{record['mean_velocity']:.12g}"),
        ("stable", {True: "yes", False: "no", None: "not known"}[record["stable"]]),
        ("multipliers", sizes),
        ("symmetry", symmetric[record["symmetric"]]),
        ("word", record["word"]),
        ("state", ", ".join(f"{name} {number:.12g}" for name, number in record["state"].items())),
    ]
    if record["twin"] is not None:
        start = ", ".join(f"{name} {number:.12g}" for name, number in record["twin"]["state"].items())
        rows.append(("mirror twin", f"drift {record['twin']['drift']:.12g}, state {start}"))
    for name, text in rows:
        if text:
            page.print(f"  {name:<14}{text}", soft_wrap=True, markup=False)


def _multiplier(multiplier: dict[str, float]) -> str:
    """A multiplier in words: exactly zero where sticking forgets a direction."""
    real, imaginary = multiplier["real"], multiplier["imaginary"]
    if real == 0.0 and imaginary == 0.0:
        return "0 (forgotten while it sticks)"
    return f"{real:.9g}" if imaginary == 0.0 else f"{real:.9g} {'+' if imaginary > 0 else '-'} {abs(imaginary):.9g}i"


def range_of(text: str) -> tuple[str, float, float]:
    """PATH=LEAST:LARGEST."""
    path, _, ends = text.partition("=")
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        raise Refusal(
            f"--over should be PATH=LEAST:LARGEST, such as machine.mass_ratio=0.2:8.1, got {text!r}"
        ) from None
    return path, low, high


def _other(system: Any, text: str) -> Any:
    """The system with another friction law, which takes over the parameters that both have, or another parameter."""
    import dataclasses

    from vibrocap.catalogue import law, laws
    from vibrocap.parameters import given_parameters

    path, _, wanted = text.partition("=")
    if not path or not wanted:
        raise Refusal(f"--against should be friction.law=NAME or PATH=VALUE, got {text!r}")
    try:
        if path != "friction.law":
            return system.with_parameters({path: float(wanted)})
        kind = law(wanted)
        shared = {field.name for field in dataclasses.fields(kind)}
        given = {name: each for name, each in given_parameters(system.friction).items() if name in shared}
        return dataclasses.replace(system, friction=kind(**given))
    except KeyError as error:
        raise Refusal(f"--against {text}: {error.args[0]}") from None
    except ValueError as error:
        told = f"; there is {', '.join(laws())}" if path == "friction.law" else ""
        raise Refusal(f"--against {text}: {error}{told}") from None
