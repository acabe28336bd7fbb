"""Fuzzed case files: each is refused with its complaints, or runs to a status; none raises anything else, or hangs.

Good cases are hurt a few times: values at and beyond their limits, of other types and other languages, keys and
sections that are missing, twice, misspelt or nested, text cut and mixed up byte by byte. What is still a case is run,
for a short time and few steps, where its parts are among those that are compiled already.
"""

import json
import random
import traceback
import warnings
from pathlib import Path

import vibrocap as vc
from torture.children import answers
from torture.outcome import Outcome
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import CaseError, case_from_dict, case_from_text, read_case
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.parameters import parameter_table

SECONDS = 20.0  # for one case; all kernels are compiled before
COMPILED = (("exponential", "harmonic"), ("lugre", "harmonic"), ("coulomb", "biharmonic"))  # with the capsule
STEPS = 20_000
NUMBERS = (
    "0", "-0.0", "1", "-1", "1e-300", "1e300", "-1e300", "5e-324", "1.7976931348623157e308", "inf", "-inf", "nan",
    "1e-9", "0.1", "3", "1e6", "1_000", "0x10", "9223372036854775808", "1" + "0" * 400, "1.0000000000000002",
)  # fmt: skip
OTHERS = (
    "true", '"heavy"', '""', "[]", "[1, 2]", "{}", "{ a = 1 }", "1979-05-27", '"\\u001b[31m"', '"m[/x]"', "'''\n'''",
    "",    "[" * 60 + "]" * 60, '"' + "x" * 5000 + '"', "'\u202e'", "=", "1 2",
)  # fmt: skip
KEYS = (
    "mass_ratio",
    "kind",
    "law",
    "angle",
    "periods",
    "tolerance",
    "max_steps",
    "a.b.c",
    '"\\u0000"',
    "x" * 300,
    "ключ",
)


def text_of(chance: random.Random) -> str:
    """A case, hurt."""
    if chance.random() < 0.8:
        machine = "pendulum-capsule"
        law, drive = chance.choice(COMPILED)
    else:
        machine, law, drive = (chance.choice(list(kinds())) for kinds in (machines, laws, drives))
    chosen = {
        "machine": ("kind", machine, machines),
        "friction": ("law", law, laws),
        "drive": ("waveform", drive, drives),
    }
    sections: dict[str, list[list[str]]] = {}
    for section, (key, name, kinds) in chosen.items():
        keys = [[key, json.dumps(name)]]
        for info in parameter_table(kinds()[name]):
            if isinstance(info.default, float) and chance.random() < 0.4:
                value = info.default * chance.choice((1.0, chance.uniform(0.2, 3.0), 10 ** chance.uniform(-3, 3)))
                keys.append([info.name, repr(value)])
        sections[section] = keys
    sections["initial"] = [["angle", repr(chance.uniform(-3, 3))]]
    sections["run"] = [["periods", repr(chance.choice((1, 2, 0.5)))], ["max_steps", str(STEPS)]]
    for _ in range(chance.choice((0, 1, 1, 2, 3))):
        keys = sections[chance.choice(list(sections))] if sections else []
        how = chance.random()
        if how < 0.55 and keys:
            chance.choice(keys)[1] = chance.choice(NUMBERS if chance.random() < 0.7 else OTHERS)
        elif how < 0.7:
            keys.insert(0, [chance.choice(KEYS), chance.choice((*NUMBERS, *OTHERS))])
        elif how < 0.8 and keys:
            keys.remove(chance.choice(keys))
        elif how < 0.85 and keys:
            keys.append(list(chance.choice(keys)))
        elif how < 0.9 and sections:
            del sections[chance.choice(list(sections))]
        else:
            sections.setdefault(chance.choice(("runs", "machine.x", "[friction]", "machine", '"\\u001b"')), [])
    text = "\n".join(
        f"[{name}]\n" + "\n".join(f"{key} = {value}" for key, value in keys) for name, keys in sections.items()
    )
    return mixed(text, chance) if chance.random() < 0.15 else text


def mixed(text: str, chance: random.Random) -> str:
    """A text cut, doubled, or with characters changed."""
    for _ in range(chance.randint(1, 5)):
        at, to = sorted(chance.randrange(len(text) + 1) for _ in range(2))
        strange = text[:at] + chance.choice("[]{}=\"'\n#.\0é\x7f") + text[at:]
        text = chance.choice((text[:at], text[:at] + text[to:], text[:to] + text[at:], strange)) or "["
    return text


def fuzz_cases(folder: Path, trials: int, seed: int) -> Outcome:
    """So many cases."""
    warnings.simplefilter("ignore")
    for law, drive in COMPILED:
        parts = {"machine": {"kind": "pendulum-capsule"}, "friction": {"law": law}, "drive": {"waveform": drive}}
        case_from_dict({**parts, "run": {"periods": 1}}).simulate()
    path, outcome, counts = folder / "case.toml", Outcome("fuzzed cases"), folder / "counts"
    counts.write_text("")

    def work(index: int) -> str:
        chance = random.Random(f"{seed} {index}")
        text = text_of(chance)
        try:
            if chance.random() < 0.2:
                path.write_bytes(text.encode("utf-8", "surrogatepass") + bytes(chance.choices(range(256), k=3)))
                case = read_case(path)
            else:
                case = case_from_text(text)
        except CaseError as error:
            return "" if error.complaints and len(str(error)) < 5000 else f"no words, or too many: {text!r}"
        except BaseException:
            return f"{text!r}\n{traceback.format_exc()[-700:]}"
        system = case.system
        if (system.friction.name, system.drive.name) not in COMPILED or system.machine.name != "pendulum-capsule":
            return ""
        if case.periods > 3 or case.max_steps > STEPS:
            return ""
        with counts.open("a") as file:
            file.write("r")
        try:
            return "" if isinstance(case.simulate().status, vc.Status) else f"no status: {text!r}"
        except ArgumentError as error:  # refused as too large for the memory, which ends the command with code 2
            return "" if "of memory" in str(error) else f"{text!r}\n{error}"
        except BaseException:
            return f"{text!r}\n{traceback.format_exc()[-700:]}"

    for index, answer in answers(work, trials, SECONDS):
        outcome.check(
            not answer,
            f"case {index}: {answer} {text_of(random.Random(f'{seed} {index}')) if answer == 'hung' else ''}",
        )
    outcome.words = f"{counts.stat().st_size:,} of them run"
    return outcome
