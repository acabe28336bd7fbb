"""What a shell is offered for the value of an option: names of parts, measures, paths and states of the case, examples.

A shell asks the command line itself, by a hidden command of cyclopts, each time that TAB is pressed. Parts of one's own
(--parts) are not offered: their file would be run at each press.
"""

import inspect
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from cyclopts import App

from vibrocap.physics.names import split_path
from vibrocap.physics.system import System

LISTED = ("machines", "laws", "drives", "controllers", "measures", "datasets")
Offered = Iterable[tuple[str, str]]  # each with what it means


def script(app: App, shell: Any) -> str:
    """The script of a shell, as cyclopts makes it, but without a space behind PATH=, which a value is to follow.

    That of zsh works under the name _vibrocap in the fpath too, and where a shell reads it by `source`.
    """
    text = app.generate_completion(shell=shell)
    if shell == "zsh":
        return text.replace("compadd -d", "compadd -S '' -d") + CALLED_IN_ZSH
    return text + NO_SPACE_IN_BASH if shell == "bash" else text


NO_SPACE_IN_BASH = """
_vibrocap_open() {
  _vibrocap
  if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then compopt -o nospace 2>/dev/null; fi
}
complete -F _vibrocap_open vibrocap
"""
CALLED_IN_ZSH = """
if [[ ${funcstack[1]} == (_vibrocap|_cyclopts_vibrocap) ]]; then
  _cyclopts_vibrocap "$@"
elif (( $+functions[compdef] )); then
  compdef _cyclopts_vibrocap vibrocap
fi
"""


def names_of(*kinds: str) -> Callable[[Any], Offered]:
    """Parts of some kinds in the catalogue, such as "laws", each with the first line of what it says of itself."""

    def offered(asked: Any) -> Offered:
        from vibrocap.physics import catalogue

        return [piece for kind in kinds for piece in _pieces(asked, described(getattr(catalogue, kind)()))]

    return offered


law_names, machine_names, drive_names = names_of("laws"), names_of("machines"), names_of("drives")


def listed_names(asked: Any) -> Offered:
    """The kinds that `vibrocap list` lists, and the names of parts."""
    return [*((kind, "") for kind in LISTED), *names_of("laws", "machines", "drives")(asked)]


def law_parameters(asked: Any) -> Offered:
    """The parameters of the law that is named on the line."""
    from vibrocap.physics.catalogue import laws
    from vibrocap.physics.parameters import parameter_table

    named = asked.get("law") or asked.get("name")
    law = laws().get(named.raw) if named is not None and named.raw else None
    return [] if law is None else _pieces(asked, {info.name: info.meaning for info in parameter_table(law)})


def example_names(asked: Any) -> Offered:
    """The examples that come with vibrocap."""
    from vibrocap.cli.examples import examples_folder, shows

    return [(path.stem, shows(path)) for path in sorted(examples_folder().glob("*.toml"))]


def data_sets(asked: Any) -> Offered:
    """Published data sets."""
    from vibrocap.records.published import DATA_SETS

    return [(name, data_set.title) for name, data_set in DATA_SETS.items()]


def measure_names(asked: Any) -> Offered:
    """Measures: those of the case on the line, else all."""
    from vibrocap.measures.during_run import measure_table

    return _pieces(asked, {name: measure.meaning for name, measure in measure_table(_system(asked)).items()})


def paths_of_case(asked: Any) -> Offered:
    """Every path of the case on the line that can be varied; behind PATH= of a kind of part what there is of it."""
    from vibrocap.case.sections import kind_paths, kinds_of
    from vibrocap.physics.dimensions.conversion import paths_in_si, quantity_in_si
    from vibrocap.studies.plan.variation import paths

    if (system := _system(asked)) is None:
        return []
    kinds = kind_paths(system.parts)
    path, equals, _ = asked.incomplete.partition("=")
    if equals:
        before, comma, _ = asked.incomplete.rpartition(",")
        begun = before + comma or f"{path}="
        return [(begun + name, "") for name in kinds_of(split_path(path)[0])] if path in kinds else []
    known = [*paths(system.parts), *kinds]
    if system.units is not None:
        without = [path for path in known if quantity_in_si(path, system).path == quantity_in_si(path, system).plain]
        known = [*paths_in_si(system.parts), *without]  # those without a unit in SI either
    return [(f"{path}=", _meaning(path, system)) for path in known]


def states_of_case(asked: Any) -> Offered:
    """The states of the case on the line, in SI with their units."""
    start = "initial."
    return [(path.removeprefix(start), meaning) for path, meaning in paths_of_case(asked) if path.startswith(start)]


def _system(asked: Any) -> System | None:
    """The system of the case on the line; None where there is none, or none that can be read."""
    from vibrocap.case.case import CaseError
    from vibrocap.io.motion_file import read_source

    case = asked.get("case")
    if case is None or not case.raw:
        return None
    try:
        return read_source(Path(case.raw).expanduser()).system
    except (CaseError, OSError):
        return None


def _meaning(path: str, system: System) -> str:
    """What the parameter of a path is; empty for a state and for a kind of part."""
    from vibrocap.physics.dimensions.conversion import path_in_si
    from vibrocap.physics.parameters import parameter_table

    place = path_in_si(path, system.parts)
    section, name = split_path(path if place is None else place[0])
    table = parameter_table(system.parts[section]) if section in system.parts else ()
    return next((row.meaning if system.units is None else row.in_si for row in table if row.name == name), "")


def described(parts: Mapping[str, Any]) -> dict[str, str]:
    """The first line of what each part says of itself."""
    return {name: inspect.cleandoc(part.__doc__ or "").partition("\n")[0] for name, part in parts.items()}


def _pieces(asked: Any, names: Mapping[str, str]) -> list[tuple[str, str]]:
    """Names behind those that stand before a comma already, which are not offered again."""
    before, comma, _ = asked.incomplete.rpartition(",")
    words = before.split(",")
    return [(before + comma + name, meaning) for name, meaning in names.items() if name not in words]
