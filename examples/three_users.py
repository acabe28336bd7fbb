"""Three users of vibrocap, in SI: a doctoral student, a friction researcher and a teacher.

    python examples/three_users.py --out three-users

Run it in a fresh clone, in the environment that `make test` makes, or with `vibrocap[plot,sweep,excel]` installed; it
takes half a minute. Every command is printed as it would be typed. In the folder it writes

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

# The contact that the researcher's data are made from, in SI, so that the fit can be compared with the truth. Its
# levels are those of the prototype.
TRUTH = {
    "bristle_stiffness": 3.0e4,  # N/m
    "bristle_damping": 120.0,  # N s/m
    "viscous_damping": 1.5,  # N s/m
    "coulomb_coefficient": 0.15,
    "static_coefficient": 0.25,
    "stribeck_velocity": 0.02,  # m/s
}
LOAD = 6.865  # N, the weight of the prototype
# Under a load that follows the motion, as the prototype's, stiffness and damping are over the load, in these units.
OVER_LOAD = {"bristle_stiffness": "per_m", "bristle_damping": "s_per_m", "viscous_damping": "s_per_m"}
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
    command("vibrocap examples prototype-in-si --to .", folder)
    command("vibrocap simulate prototype-in-si.toml --out motion.csv", folder)
    orbit = json.loads(command("vibrocap orbit prototype-in-si.toml --json", folder))
    slope = "--over environment.inclination_deg=0:6 --points 13 --measure mean_velocity --json"
    crossing = json.loads(command(f"vibrocap crossing prototype-in-si.toml {slope}", folder))
    axes = "--over drive.frequency_Hz=1:3:21 --over drive.amplitude_N_m=0.05:0.55:26"
    measures = "--measure mean_velocity,cost_of_transport,least_reaction --settle 1e-6"
    command(f"vibrocap sweep prototype-in-si.toml {axes} {measures} --out map", folder)
    command(
        "vibrocap sweep prototype-in-si.toml --over environment.inclination_deg=0:6:61 --settle 1e-6 --out slope",
        folder,
    )

    study = vc.open_study(folder / "map")
    for ending in ("csv", "xlsx", "mat"):
        vc.write_study(study, folder / f"map.{ending}")
    here = study.sel({"drive.frequency_Hz": 1.3, "drive.amplitude_N_m": 0.35}, method="nearest")
    runs = study.to_dataframe().reset_index()
    runs = runs[runs.settled]
    fastest = runs.loc[runs.mean_velocity.abs().idxmax()]
    return {
        "speed [m/s]": orbit["mean_velocity"]["value"],
        "stable": orbit["stable"],
        "steepest slope [deg]": crossing["found"][0]["at"]["value"],
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


def friction_researcher(folder: Path, damper: Path | None = None) -> tuple[dict, vc.Fit]:
    """Which friction parameters do the records say, how surely, and how does the prototype walk with them?

    damper: folder with published measurements of a rotary damper (`vibrocap list datasets --fetch rotary-damper`),
        which are fitted too, an earthquake held out
    """
    records = vc.read_records(rig_records(folder))  # units are read from the headings
    fit = vc.fit(records, "lugre", load=LOAD)
    fit.save(folder / "fit")  # fit.json, and friction.toml: the section [friction] of a case in SI

    before, _, rest = (folder / "prototype-in-si.toml").read_text(encoding="utf-8").partition("[friction]")
    values = {name: fit[name].value / (LOAD if name in OVER_LOAD else 1.0) for name in TRUTH}
    keys = {"stribeck_velocity": "stribeck_velocity_m_per_s"} | {
        name: f"{name}_{unit}" for name, unit in OVER_LOAD.items()
    }
    fitted = "\n".join(f"{keys.get(name, name)} = {value!r}" for name, value in values.items())
    case = f'{before}[friction]\nlaw = "lugre"\n{fitted}\n{rest[rest.index("[drive]") :]}'
    (folder / "fitted.toml").write_text(case, encoding="utf-8")
    orbit = json.loads(command("vibrocap orbit fitted.toml --json", folder))
    inside = [fit[name].low <= true <= fit[name].high for name, true in TRUTH.items()]
    published = {}
    if damper is not None:
        dahl = vc.fit(vc.rotary_damper(damper), "dahl", held_out="eq_KocaeliMCE_window", intervals="covariance")
        published = {"published damper, error": dahl.relative_rmse, "of its earthquake": dahl.held_out_relative_rmse}
    return {
        **{name: f"{fit[name].value:.5g} ({fit[name].low:.5g} to {fit[name].high:.5g})" for name in TRUTH},
        "truths inside their intervals": f"{sum(inside)} of {len(inside)}",
        "errors are white noise": fit.residuals.white,
        "speed with the fitted law [m/s]": orbit["mean_velocity"]["value"],
        **published,
    }, fit


def teacher(folder: Path) -> dict:
    """A page for the lecture: the machine of the student, with sliders, in one file that needs no network."""
    command("vibrocap lab prototype-in-si.toml --laws exponential --drives biharmonic --out lab.html", folder)
    command("vibrocap simulate prototype-in-si.toml --cite bibtex", folder)
    return {"size of the page [kB]": (folder / "lab.html").stat().st_size // 1000}


def figure(folder: Path, fit: vc.Fit, steepest: float) -> None:
    """The figure over two columns (7 inches): motion, map, slope and friction, with units on every axis."""
    motion = vc.read_case(folder / "prototype-in-si.toml").simulate()
    with vc.style({"font.size": 8, "axes.titlesize": 8, "legend.fontsize": 7}):
        drawn, ((a, b), (c, d)) = plt.subplots(2, 2, figsize=(7.0, 5.4), layout="constrained")
        vc.plot(motion, "velocity", periods=1, ax=a)
        vc.plot(vc.open_study(folder / "map"), "mean_velocity", ax=b)
        vc.plot(vc.open_study(folder / "slope"), "mean_velocity", ax=c)
        c.axvline(steepest, color="0.5", linewidth=0.8, linestyle="--")
        c.annotate(f"climbs {steepest:.2f}°", (steepest, 0.0), (5, 25), textcoords="offset points")
        vc.plot(fit, "slow", ax=d)
        d.set_xlim(0.0, 1.5)
        titles = {a: "(a) motion", b: "(b) map, hatched: lifts off", c: "(c) slope", d: "(d) friction on the rig"}
        for axes, title in titles.items():
            axes.set_title(title, loc="left")
            if (legend := axes.get_legend()) is not None and axes in (c, d):
                legend.set(visible=False)
                legend.set_in_layout(False)
        d.text(0.5, 0.8, "grey: measured\nblue: fitted", transform=d.transAxes, ha="center", va="center", fontsize=6.5)
        drawn.savefig(folder / "figure.pdf")
        drawn.savefig(folder / "figure.png", dpi=200)
        plt.close(drawn)


def main(folder: Path, damper: Path | None = None) -> dict:
    """Play all three users in a folder, which is made where it is missing; returns their answers by user."""
    folder.mkdir(parents=True, exist_ok=True)
    student = doctoral_student(folder)
    researcher, fit = friction_researcher(folder, damper)
    answers = {"doctoral student": student, "friction researcher": researcher, "teacher": teacher(folder)}
    figure(folder, fit, student["steepest slope [deg]"])
    for user, numbers in answers.items():
        print(f"\n{user}")
        for name, value in numbers.items():
            print(f"  {name:34}{f'{value:.4g}' if isinstance(value, float) else value}")
    return answers


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("three-users"), help="folder for what is written")
    parser.add_argument("--damper", type=Path, help="folder of the data set rotary-damper, to fit it too")
    arguments = parser.parse_args()
    main(arguments.out, arguments.damper)
