"""Three users of vibrocap, in SI: a doctoral student, a friction researcher and a teacher.

    python examples/three_users.py --out three-users

Run it in a fresh clone after `make` has made the environment, or with `vibrocap[plot,sweep,excel]` installed; it takes
half a minute. Every command is printed as it would be typed. In the folder it writes

    figure.pdf, .png      a figure over two columns: the student's motion, map and slope, the researcher's fit
    map.csv, .xlsx, .mat  the student's table in three formats, with units
    lab.html              the teacher's page: the student's machine with sliders, in one file

and it returns the answers: speed, slope, stability, energy per metre, friction parameters with their intervals.
"""

import argparse
import json
import shlex
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import vibrocap as vc

# What the student has measured on the prototype; each number with its unit. The pendulum presses on the ground as it
# swings, so the normal load is "dynamic", and the capsule may lift off.
PROTOTYPE = """\
units = "SI"

[machine]
kind = "pendulum-capsule"
capsule_mass_kg = 0.5
pendulum_mass_kg = 0.2
pendulum_length_m = 0.1
stiffness_N_m_per_rad = 0.4
damping_N_m_s_per_rad = 0.02
normal_load = "dynamic"

[friction]
law = "exponential"
coulomb_coefficient = 0.15
static_coefficient = 0.25
decay_rate_s_per_m = 10.0

[drive]
waveform = "biharmonic"
amplitude_N_m = 0.35
frequency_Hz = 1.3
second_amplitude_N_m = 0.12
second_phase_deg = 180

[environment]
inclination_deg = 0

[run]
periods = 40
"""

# The contact that the researcher's data are made from, in SI, so that the fit can be compared with the truth. Its levels
# are those of the student's law.
TRUTH = {
    "bristle_stiffness": 3.0e4,  # N/m
    "bristle_damping": 120.0,  # N s/m
    "viscous_damping": 1.5,  # N s/m
    "coulomb_coefficient": 0.15,
    "static_coefficient": 0.25,
    "stribeck_velocity": 0.02,  # m/s
}
LOAD = 6.865  # N, the weight of the prototype
NOISE = 0.02  # of the standard deviation of the force
STROKES = {"creep": (0.0005, 1.0), "slow": (0.05, 1.0), "fast": (0.2, 2.0)}  # amplitude of the velocity (m/s), Hz


def command(line: str, folder: Path) -> str:
    """Run a command of vibrocap in a folder, as typed in a terminal, and return what it prints."""
    print(f"$ {line}", flush=True)
    words = [sys.executable, "-m", *shlex.split(line)]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, encoding="utf-8")
    if done.returncode:
        raise SystemExit(f"{line}\n{done.stderr}")
    return done.stdout


def doctoral_student(folder: Path) -> dict:
    """How fast is the prototype, how steep may it go, where does it lift off, is it stable, what does a metre cost?"""
    (folder / "prototype.toml").write_text(PROTOTYPE, encoding="utf-8")
    command("vibrocap simulate prototype.toml --out motion.csv", folder)
    orbit = json.loads(command("vibrocap orbit prototype.toml --json", folder))
    slope = "--over environment.inclination_deg=0:6 --points 13 --measure mean_velocity --json"
    crossing = json.loads(command(f"vibrocap crossing prototype.toml {slope}", folder))
    axes = "--over drive.frequency_Hz=1:3:21 --over drive.amplitude_N_m=0.05:0.55:26"
    measures = "--measure mean_velocity,cost_of_transport,least_reaction --settle 1e-6"
    command(f"vibrocap sweep prototype.toml {axes} {measures} --out map", folder)
    command("vibrocap sweep prototype.toml --over environment.inclination_deg=0:6:61 --settle 1e-6 --out slope", folder)

    study = vc.open_study(folder / "map")
    for ending in ("csv", "xlsx", "mat"):
        vc.write_study(study, folder / f"map.{ending}")
    here = study.sel({"drive.frequency_Hz": 1.3, "drive.amplitude_N_m": 0.35}, method="nearest")
    runs = study.to_dataframe().reset_index()
    runs = runs[runs.settled]
    fastest = runs.loc[runs.mean_velocity.abs().idxmax()]
    return {
        "speed [m/s]": orbit["mean_velocity"],
        "stable": orbit["stable"],
        "steepest slope [deg]": crossing["found"][0]["at"],
        "energy per metre [J/m]": float(here.cost_of_transport),
        "least load on the ground [N]": float(here.least_reaction),
        "runs that lift off": int((study.least_reaction.isnull()).sum()),
        "fastest without lift-off [m/s]": float(fastest.mean_velocity),
        "at [Hz]": float(fastest["drive.frequency_Hz"]),
        "and [N m]": float(fastest["drive.amplitude_N_m"]),
    }


def rig_records(folder: Path) -> list[Path]:
    """Records of a friction rig as CSV files with units in their headings: time, force and velocity."""
    levels = {name: TRUTH[name] * LOAD for name in ("coulomb_coefficient", "static_coefficient")}
    contact = vc.LuGre(**{**TRUTH, **levels})  # with the levels in newtons the load is 1
    noise = np.random.default_rng(1)
    paths = []
    for name, (amplitude, frequency) in STROKES.items():
        time = np.linspace(0.0, 4.0 / frequency, 2001)
        velocity = amplitude * np.sin(2.0 * np.pi * frequency * time)
        force = vc.driven_force(contact, time, velocity).force
        force = force + NOISE * np.std(force) * noise.standard_normal(len(time))
        paths.append(folder / f"{name}.csv")
        table = np.column_stack((time, force, velocity))
        np.savetxt(paths[-1], table, "%.9g", ",", header="time [s],force [N],velocity [m/s]", comments="")
    return paths


def friction_researcher(folder: Path) -> dict:
    """Which friction parameters do the records say, how surely, and how does the prototype walk with them?"""
    records = " ".join(path.name for path in rig_records(folder))
    command(f"vibrocap fit {records} --law lugre --load {LOAD} --out fit", folder)
    found = json.loads((folder / "fit" / "fit.json").read_text(encoding="utf-8"))

    before, _, rest = PROTOTYPE.partition("[friction]")
    after = rest[rest.index("[drive]") :]
    fitted = (folder / "fit" / "friction.toml").read_text(encoding="utf-8")
    (folder / "fitted.toml").write_text(f"{before}{fitted}\n{after}", encoding="utf-8")
    orbit = json.loads(command("vibrocap orbit fitted.toml --json", folder))
    intervals = {each["name"]: (each["low"], each["value"], each["high"]) for each in found["parameters"]}
    return {
        **{name: intervals[name] for name in TRUTH},
        "truths inside their intervals": sum(low <= TRUTH[n] <= high for n, (low, _, high) in intervals.items() if n in TRUTH),
        "speed with the fitted law [m/s]": orbit["mean_velocity"],
    }


def teacher(folder: Path) -> dict:
    """A page for the lecture: the machine of the student, with sliders, in one file that needs no network."""
    command("vibrocap lab prototype.toml --laws exponential --drives biharmonic --out lab.html", folder)
    command("vibrocap cite prototype.toml --bibtex", folder)
    return {"size of the page [kB]": (folder / "lab.html").stat().st_size // 1000}


def figure(folder: Path, answers: dict) -> None:
    """The figure over two columns (7 inches): motion, map, slope and friction, with units on every axis."""
    motion = vc.read_case(folder / "prototype.toml").simulate()
    records = vc.read_records([folder / f"{name}.csv" for name in STROKES], load=LOAD)
    fit = vc.fit(records, "lugre", intervals="covariance")
    with vc.style({"font.size": 8, "axes.titlesize": 8, "legend.fontsize": 7}):
        drawn, ((a, b), (c, d)) = plt.subplots(2, 2, figsize=(7.0, 5.4), layout="constrained")
        vc.plot(motion, "velocity", periods=1, ax=a)
        vc.plot(vc.open_study(folder / "map"), "mean_velocity", ax=b)
        vc.plot(vc.open_study(folder / "slope"), "mean_velocity", ax=c)
        c.axvline(answers["steepest slope [deg]"], color="0.5", linewidth=0.8, linestyle="--")
        vc.plot(fit, "slow", ax=d)
        for axes, title in zip((a, b, c, d), ("motion", "map, and where it lifts off", "slope", "friction"), strict=True):
            axes.set_title(f"({'abcd'[(a, b, c, d).index(axes)]}) {title}", loc="left")
        drawn.savefig(folder / "figure.pdf")
        drawn.savefig(folder / "figure.png", dpi=200)
        plt.close(drawn)


def main(folder: Path) -> dict:
    """Play all three users in a folder, which is made where it is missing; returns their answers by user."""
    folder.mkdir(parents=True, exist_ok=True)
    answers = {user.__name__: user(folder) for user in (doctoral_student, friction_researcher, teacher)}
    figure(folder, answers["doctoral_student"])
    for user, found in answers.items():
        print(f"\n{user.replace('_', ' ')}")
        for name, value in found.items():
            print(f"  {name:34}{value}")
    return answers


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("three-users"), help="folder for what is written")
    main(parser.parse_args().out)
