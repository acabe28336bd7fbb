"""Fuzzed command lines: each ends with its exit code, says why where that is not 0, and never with a traceback.

Commands of short work get options of all kinds, good and bad values among them. Where one of them must be refused, the
exit code must be 2.
"""

import contextlib
import io
import math
import os
import random
import traceback
import warnings
from pathlib import Path

from torture.children import answers
from torture.full_disk import CASE
from torture.outcome import Outcome
from vibrocap.cli.main import main

SECONDS = 20.0  # for one command; all kernels are compiled before
CODES = (0, 2, 3)

# option: good values, values that must be refused
Values = dict[str, tuple[tuple[str, ...], tuple[str, ...]]]
NO_NUMBER = ("nan", "x", "", "-1", "1e400", "[1]", "\x1b[31m")
SETTINGS: Values = {
    "--periods": (("1", "2"), (*NO_NUMBER, "0", "1e-300", "inf")),
    "--tolerance": (("1e-8", "1e-6"), (*NO_NUMBER, "0", "1", "1e-300")),
}
PICTURE: Values = {"--plot": (("a.svg",), ("a.jpg", "a", ".", "case.toml/a.png", "/dev/null/a.png", "/proc/a.png"))}
COMMANDS: dict[str, tuple[tuple[str, ...], Values]] = {
    "simulate": (
        ("case.toml",),
        {
            **SETTINGS,
            **PICTURE,
            "--out": (("a.csv", "a.nc"), ("a.xls", "", "case.toml/a.nc", "/proc/a.nc")),
            "--json": (("",), ()),
            "--animate": ((), ("a.avi", "a")),
            "--cite": (("text", "bibtex"), ("json",)),
            "--analyses": ((), ("orbits",)),
            "--nothing": ((), ("1",)),
        },
    ),
    "sweep": (
        ("case.toml", "--periods", "2"),
        {
            "--over": (
                ("machine.mass_ratio=1:3:2", "drive.amplitude=1,2", "friction.law=exponential,lugre"),
                ("machine.mas=1:3:2", "machine.mass_ratio", "machine.mass_ratio=1:x:2", "=1:2:3",
                 "machine.mass_ratio=-1:1:3", "machine.mass_ratio=1:3:0", "machine.mass_ratio=1:3:-4",
                 "machine.mass_ratio=1:3:1.5",
                 "machine.mass_ratio=log:0:3:4", "friction.law=lugree", "m[/x]=1:2:3"),
            ),
            "--measure": (("mean_velocity", "mode_sequence"), ("velocity", "m[/x]")),
            "--tolerance": SETTINGS["--tolerance"],
            "--window": (("1",), ("0", "-1", "x", "1.5")),
            "--settle": (("1e-6",), ("nan", "-1", "x")),
            "--export": (("s.nc", "s.csv"), ("s.xls", "s", "/proc/s.nc")),
            "--threads": (("1",), ("0", "-1", "x")),
            "--device": (("cpu",), ("gpu", "")),
            "--design": ((), ("sobel",)),
            "--cases": ((), ("nowhere.csv", "case.toml")),
        },
    ),
    "plot": (("map.nc",), {
        "--measure": (("mean_velocity", "status"), ("velocity", "m[/x]")),
        "--out": (("a.svg",), ("a.jpg", "a", "/proc/a.png")),
        "--at": ((), ("drive.frequency", "drive.frequency=x", "=1")),
        "--border": ((), ("status", "borders")),
        "--dead-band": (("0.1",), ("-1", "nan", "x")),
    }),
    "orbit": (("case.toml",), {"--json": (("",), ()), "--settle-periods": (("20",), ("x", "0", "-1"))}),
    "branch": (("case.toml", "--points", "3"), {
        "--over": (("drive.amplitude=1.6:1.9",), ("drive.amplitude", "drive.amp=1:2", "drive.amplitude=2:x")),
        "--json": (("",), ()),
    }),
    "basins": (("case.toml", "--resolution", "4"), {
        "--plane": (("angle=-1:1,angle_rate=-1:1",), ("angle", "angl=-1:1,angle_rate=-1:1", "angle=1:x,position=0:1")),
        "--phase": (("0.5",), ("x", "nan")),
        "--json": (("",), ()),
    }),
    "crossing": (("case.toml", "--points", "3"), {
        "--over": (("drive.amplitude=1.5:1.9",), ("drive.amplitude", "drive.amp=1:2", "drive.amplitude=2:x")),
        "--value": (("0",), ("x", "nan")),
        "--measure": ((), ("velocity", "mode_sequence")),
    }),
    "equilibria": (("rest.toml",), {
        "--json": (("",), ()),
        "--start": ((), ("x",)),
        "--over": (("machine.belt_speed=0.9:1.1",), ("drive.amp=1:2",)),
    }),
    "optimise": (("case.toml", "--evaluations", "20"), {
        "--over": (("drive.amplitude=1.7:1.9",),
                   ("drive.amplitude", "friction.law=log:0.5:3", "drive.amp=1:2", "drive.amplitude=2:1")),
        "--subject-to": (("stick_fraction < 2",), ("stick_fraction", "velocity < 1")),
        "--robust": ((), ("worst",)),
        "--resume": ((), ("",)),
    }),
    "robust": (("case.toml", "--samples", "8"), {
        "--uncertain": (("machine.mass_ratio=2:3",), ("machine.mass_ratio", "friction.law=1:2", "machine.mas=1:2")),
        "--for": (("mean_velocity",), ("velocity",)),
        "--json": (("",), ()),
    }),
    "calibrate": (("case.toml", "--to", "rows.csv", "--starts", "8"), {
        "--over": (("friction.coulomb_coefficient=0.1:0.3",), ("friction.coulomb=0.1:0.3", "drive.frequency=2:1")),
        "--held-out": (("1",), ("0", "x", "99")),
        "--json": (("",), ()),
    }),
    "reproduce": (("--only", "fig99"), {"--out": ((), ("case.toml",))}),
    "lab": (("case.toml",), {
        "--out": (("a.html",), ("a.txt", "/proc/a.html")),
        "--laws": (("coulomb",), ("coulom",)),
        "--machines": ((), ("pendulum",)),
    }),
    "export": (("case.toml",), {
        "--to": (("c", "mjcf"), ("d", "rates", "")),
        "--out": (("a-folder", "a.xml"), ("case.toml", "/proc/a")),
        "--name": (("plant",), ("a b", "")),
        "--input": (("drive",), ("torque",)),
        "--judge": ((), ("1",)),
    }),
    "new": ((), {
        "--law": (("coulomb",), ("coulom", "")),
        "--drive": (("square", "table"), ("squar",)),
        "--out": (("fresh.toml",), ("fresh.txt", "/proc/a.toml")),
        "--si": (("",), ()),
        "--from": (("case.toml",), ("nowhere.toml", "bytes.toml")),
        "--scales": (
            ("pendulum_mass_kg=0.2,pendulum_length_m=0.25",),
            ("pendulum_mass_kg=0.2", "pendulum_mass_kg=1e300,pendulum_length_m=1e300", "mass=1", "pendulum_mass_kg=x"),
        ),
        "--to": ((), ("si-units",)),
    }),
    "examples": ((), {"--to": (("copies",), ("case.toml", "/proc/a"))}),
    "stick-slip": (("records.csv",), {
        "--stiffness": (("168",), ("-1", "0", "x", "nan")),
        "--speed": (("1e-3",), ("x", "nan")),
        "--mass": (("0.03",), ("x", "-1")),
        "--record": (("a",), ("m[/y]",)),
        "--columns": ((), ("force", "force=nowhere")),
        "--units": ((), ("force", "force=parsec")),
        **PICTURE,
    }),
    "fit": (("records.csv", "--steady", "--starts", "1", "--intervals", "covariance", "--law", "coulomb"), {
        "--fixed": ((), ("coulomb_coefficient=-1", "coulomb_coefficient=x", "mu=1", "coulomb_coefficient")),
        "--free": ((), ("mu",)),
        "--hold-out": (("a",), ("nowhere", "*")),
        "--loss": (("linear", "huber"), ("square",)),
        "--columns": ((), ("force", "force=nowhere")),
        "--units": ((), ("force=parsec",)),
        "--load": (("1",), ("0", "-1", "x", "nan")),
        "--cutoff": ((), ("-1", "x", "1e9")),
    }),
    "friction": (("coulomb",), {
        "--json": (("",), ()),
        "--set": (("coulomb_coefficient=0.2",), ("mu=1", "coulomb_coefficient=x", "coulomb_coefficient")),
        "--mass": ((), ("1",)),
    }),
    "list": (("measures",), {
        "--json": (("",), ()),
        "--fetch": ((), ("nowhere",)),
        "--parts": ((), ("nowhere.py", "case.toml")),
        "--quick": ((), ("1",)),
    }),
    "sweeep": ((), {"--over": (("a",), ())}),
}  # fmt: skip
FILES = ("case.toml", "nowhere.toml", "records.csv", "map", "map.nc", "cut.nc", "cut.csv", "cut.npz", ".", "",
         "m[/x].toml", "bytes.mat", "bytes.toml", "/dev/null", "deep.toml")  # fmt: skip
STRANGE = ("--", "-", "--help", "-x", "\0")
# What a command cannot do without.
NEEDS = dict.fromkeys(("branch", "crossing", "optimise", "calibrate"), ("--over",)) | {
    "sweep": ("--over", "--export"),
    "basins": ("--plane",),
    "robust": ("--uncertain",),
    "export": ("--out",),
}
SEVERAL = (
    "plot",
    "fit",
    "export",
    "crossing",
    "calibrate",
    "branch",
    "optimise",
    "orbit",
    "new",
)  # ends by values


def command_line(chance: random.Random) -> tuple[list[str], set[int]]:
    """A command line, and the exit codes that it may end with."""
    name = chance.choice(list(COMMANDS))
    begin, options = COMMANDS[name]
    words, codes = [name, *begin], {0, 3}
    if name in ("sweeep", "reproduce"):
        codes = {2}
    if chance.random() < 0.15 and len(words) > 1:
        words[1] = chance.choice(FILES)
        codes = {0, 2, 3}
    used = set()
    for option in chance.sample(list(options), min(len(options), chance.randint(0, 4))):
        good, bad = options[option]
        if not good and not bad:
            continue
        wrong = bool(bad) and (not good or chance.random() < 0.4)
        value = chance.choice(bad if wrong else good)
        used.add(option)
        words += [option, value] if value or wrong else [option]
        codes = {2} if wrong else codes
    if not used.issuperset(NEEDS.get(name, ())):
        codes = {2}
    if chance.random() < 0.1:  # words of any kind at any place
        words.insert(chance.randint(0, len(words)), chance.choice((*FILES, *NO_NUMBER, *STRANGE)))
        codes = set(CODES)
    if name == "stick-slip" and "--plot" in used and codes != {2}:
        codes |= {2}  # a diagram of both records needs stiffness and speed
    return words, codes | (set(CODES) if name in SEVERAL and codes != {2} else set())


def prepared(folder: Path) -> None:
    """Files that commands can read, whole ones and others; kernels that they need."""
    os.chdir(folder)
    Path("case.toml").write_text(CASE)
    Path("rest.toml").write_text(
        '[machine]\nkind = "oscillator"\nbelt_speed = 1.0\n[friction]\nlaw = "stribeck"\n'
        '[drive]\nwaveform = "constant"\n'
    )
    Path("rows.csv").write_text(
        "drive.amplitude,mean_velocity\n" + "".join(f"{1.6 + 0.05 * i},{0.02 + 0.001 * i}\n" for i in range(6))
    )
    Path("deep.toml").write_text("[machine]\nkind." + 6000 * "a." + "b = 1")
    Path("bytes.toml").write_bytes(bytes(range(256)))
    Path("bytes.mat").write_bytes(bytes(range(256)))
    rows = (
        f"{name},{0.01 * i},{math.copysign(0.3, math.sin(i / 9))},{math.sin(i / 9)}"
        for name in "ab"
        for i in range(300)
    )
    Path("records.csv").write_text("\n".join(("record,t,F,v", *rows)))
    for line in (
        ("simulate", "case.toml", "--out", "cut.nc", "--plot", "a.svg"),
        ("simulate", "case.toml", "--out", "cut.csv"),
        ("sweep", "case.toml", "--over", "drive.amplitude=1,2", "--over", "friction.law=exponential,lugre",
         "--periods", "2", "--out", "map", "--export", "map.nc"),
        ("fit", *COMMANDS["fit"][0]),
        ("orbit", "case.toml"),
        ("branch", *COMMANDS["branch"][0], "--over", "drive.amplitude=1.6:1.9"),
        ("basins", *COMMANDS["basins"][0], "--plane", "angle=-1:1,angle_rate=-1:1"),
        ("crossing", *COMMANDS["crossing"][0], "--over", "drive.amplitude=1.5:1.9"),
        ("equilibria", "rest.toml", "--over", "machine.belt_speed=0.9:1.1"),
        ("optimise", *COMMANDS["optimise"][0], "--over", "drive.amplitude=1.7:1.9",
         "--subject-to", "stick_fraction < 2"),
        ("robust", *COMMANDS["robust"][0], "--uncertain", "machine.mass_ratio=2:3"),
        ("calibrate", *COMMANDS["calibrate"][0], "--over", "friction.coulomb_coefficient=0.1:0.3"),
    ):  # fmt: skip
        assert main(line) in (0, 3), line
    for name in ("cut.nc", "cut.csv"):
        Path(name).write_bytes(Path(name).read_bytes()[:700])
    Path("cut.npz").write_bytes(b"PK\x03\x04 and no more")


def fuzz_commands(folder: Path, trials: int, seed: int) -> Outcome:
    """So many command lines."""
    warnings.simplefilter("ignore")
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        setup = os.fork()  # reading a store starts a thread, which the children must not inherit
        if not setup:
            prepared(folder)
            os._exit(0)
        assert os.waitpid(setup, 0)[1] == 0
    os.chdir(folder)
    outcome, counts = Outcome("fuzzed commands"), folder / "counts"
    counts.write_text("")

    def work(index: int) -> str:
        words, codes = command_line(random.Random(f"{seed} {index}"))
        out, err = io.StringIO(), io.StringIO()
        try:
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                code = main(words)
        except SystemExit as end:
            code = end.code
        except BaseException:
            return f"{words}\n{traceback.format_exc()[-900:]}"
        with counts.open("a") as file:
            file.write(f"{code} ")
        if code not in codes:
            return f"{words}: code {code}, not {codes}: {err.getvalue()[-300:]}"
        if code and not err.getvalue().strip():
            return f"{words}: code {code} and no word"
        return f"{words}: {err.getvalue()[-600:]}" if "Traceback" in err.getvalue() + out.getvalue() else ""

    for index, answer in answers(work, trials, SECONDS):
        given = f" {command_line(random.Random(f'{seed} {index}'))}" if answer == "hung" else ""
        outcome.check(not answer, f"command {index}: {answer}{given}")
    ends = counts.read_text().split()
    outcome.words = ", ".join(f"{ends.count(code):,} ended with {code}" for code in sorted(set(ends)))
    return outcome
