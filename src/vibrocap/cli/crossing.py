"""`vibrocap crossing`: where a measure of the steady motion of a case takes a value over a parameter."""

from pathlib import Path
from typing import Any

from vibrocap.cli.exits import INCOMPLETE, OK, complain
from vibrocap.cli.terminal import Page, Refusal, progress


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
    from vibrocap.io.motion_file import read_source
    from vibrocap.io.record import json_text
    from vibrocap.orbits.crossings.crossing import CrossingKind
    from vibrocap.orbits.crossings.crossing import crossing as crossings

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


def range_of(
    text: str, option: str = "--over", example: str = "machine.mass_ratio=0.2:8.1"
) -> tuple[str, float, float]:
    """PATH=LEAST:LARGEST."""
    path, _, ends = text.partition("=")
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        raise Refusal(f"{option} should be PATH=LEAST:LARGEST, such as {example}, got {text!r}") from None
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
