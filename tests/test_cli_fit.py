"""The command fit: exit codes, what it refuses and warns of, what it prints and writes."""

import csv
import html
import importlib.util
import json
import re
import shlex

import numpy as np
import pytest
from scipy.special import erfinv

import cases
from bench_case import BENCH
from vibrocap.case.case import CaseError, case_from_text
from vibrocap.cli.fit_request import TERM_NAMES
from vibrocap.cli.main import main
from vibrocap.cli.terminal import INCOMPLETE, OK
from vibrocap.identification import fit as fits
from vibrocap.identification.fit_result import Fit, case_section
from vibrocap.identification.problem.prediction import BESIDE
from vibrocap.identification.problem.terms import TERMS
from vibrocap.identification.search import SearchStatus
from vibrocap.physics.friction.curves import Exponential

HAS_PICTURES = importlib.util.find_spec("matplotlib") is not None
COULOMB, STATIC, RATE = 0.8, 1.5, 50.0  # N, N, s/m
NOISE, SAMPLES = 0.02, 400  # of the force's standard deviation
STEADY = ("--law", "exponential", "--steady")  # a law whose curve needs no kernel


def force_of(velocity):
    """The exponential law, 0 at rest."""
    return np.sign(velocity) * (COULOMB + (STATIC - COULOMB) * np.exp(-RATE * np.abs(velocity)))


def write_record(path, amplitude=0.1, *, header="time,velocity,force", scale=1.0, seed=0):
    """A file with the force of the exponential law under a sinusoid; noise is normal quantiles in a shuffled order."""
    time = np.linspace(0.0, 6.0, SAMPLES)
    velocity = amplitude * np.sin(np.pi * time + 0.3)
    force = force_of(velocity)
    quantiles = np.sqrt(2) * erfinv(2 * (np.arange(SAMPLES) + 0.5) / SAMPLES - 1)
    force = force + NOISE * np.std(force) * np.random.default_rng(seed).permutation(quantiles)
    np.savetxt(path, np.stack([time, velocity, scale * force], axis=1), delimiter=",", header=header, comments="")
    return path


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder as the current one, with two records."""
    monkeypatch.chdir(tmp_path)
    write_record(tmp_path / "wide.csv", 0.1, seed=1)
    write_record(tmp_path / "narrow.csv", 0.05, seed=2)
    return tmp_path


def bare(number):
    """A number of a record without its unit."""
    return number["value"] if isinstance(number, dict) else number


def values(record, name="parameters"):
    """The parameters of a fit by name."""
    return {each["name"]: bare(each["value"]) for each in record[name]}


def command(*arguments) -> int:
    return main(["fit", *map(str, arguments)])


def refused(capsys, *arguments, **options) -> str:
    """What stands on stderr of a command that was refused."""
    return cases.refused(capsys, "fit", *arguments, **options)


# --- what is printed and written -------------------------------------------------------------------------------------


def test_fit_prints_parameters_intervals_and_errors(folder, capsys):
    assert command("wide.csv", "narrow.csv", *STEADY, "--hold-out", "narrow") == OK
    text = capsys.readouterr().out
    for words in ("exponential: converged", "95 % interval", "decay_rate", "held out", "wide", "narrow"):
        assert words in text


def test_numbers_of_the_fit_are_those_of_the_law(folder, capsys):
    assert command("wide.csv", *STEADY, "--json") == OK
    content = json.loads(capsys.readouterr().out)
    assert set(content) >= {"law_name", "status", "parameters", "records", "identifiability", "options"}
    for parameter in content["parameters"]:
        true = {"coulomb_coefficient": COULOMB, "static_coefficient": STATIC, "decay_rate": RATE}[parameter["name"]]
        # 4.5 standard errors: 1 in 1e5 for each parameter, and the noise is the same in each run
        value, error, low, high = (bare(parameter[name]) for name in ("value", "standard_error", "low", "high"))
        assert abs(value - true) < 4.5 * error
        assert low < value < high
    # the noise is NOISE of the clean deviation; a fit of three parameters takes about 3/400 of its square
    assert content["relative_rmse"] == pytest.approx(NOISE, rel=0.03)


@pytest.mark.slow
def test_files_of_a_fit(folder, capsys):
    further = ("--bootstrap", "20", "--design", "amplitude=1e-3:0.1,frequency=0.2:1", "--out", "new/fit")
    page = ("--report",) if HAS_PICTURES else ()
    assert command("wide.csv", "narrow.csv", *STEADY, "--hold-out", "narrow", *further, *page) == OK
    names = {path.name for path in (folder / "new" / "fit").iterdir()}
    assert names >= {"fit.json", "friction.toml", "residuals.csv"}
    assert ({"fit.png", "residuals.png", "report.html"} <= names) == HAS_PICTURES
    text = capsys.readouterr().out
    assert all(f"new/fit/{name}" in text for name in names)
    data = json.loads((folder / "new/fit/fit.json").read_text())
    section = (folder / "new/fit/friction.toml").read_text()
    if HAS_PICTURES:  # the page shows all of it, and the line on it does all again
        shown = (folder / "new/fit/report.html").read_text()
        again = html.unescape(re.search(r"<code>(vibrocap fit .*?)</code>", shown)[1])
        assert main(shlex.split(again)[1:]) == OK
        same = json.loads((folder / "new/fit/fit.json").read_text())
        assert same | {"seconds": 0} == data | {"seconds": 0}
        for words in ("They are as white noise would be", "in 20 refits of blocks", "The next experiments", section):
            assert html.escape(words) in shown
        assert capsys.readouterr().out.partition(" starts, ")[0] == text.partition(" starts, ")[0]
    rate = case_from_text(BENCH + section).system.parameter("friction.decay_rate_s_per_m")
    assert rate == pytest.approx(values(data)["decay_rate"], rel=1e-15)
    with (folder / "new/fit/residuals.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["record"], row["held_out"]) for row in rows} == {("wide", "0"), ("narrow", "1")}
    error = np.array([float(row["error_N"]) for row in rows if row["record"] == "narrow"])
    fitted, actual = (np.array([float(row[column]) for row in rows]) for column in ("fitted_N", "measured_N"))
    assert np.array([float(row["error_N"]) for row in rows]) == pytest.approx(fitted - actual, abs=1e-8)
    held_out = next(row for row in data["records"] if row["name"] == "narrow")
    assert np.sqrt(np.mean(error**2)) == pytest.approx(held_out["rmse"]["value"], rel=1e-6)  # nine digits are written


def test_forces_of_a_fit_without_a_load_become_coefficients_over_a_constant_load_only(folder):
    """The levels are newtons: a case with its load in N has coefficients of them, a dynamic load refuses them."""
    law = case_section(Exponential(3.0, 6.0, 40.0), in_si=True, known_load=False)
    assert law.splitlines()[2:4] == ["coulomb_force_N = 3.0", "static_force_N = 6.0"]
    loaded = BENCH.replace('normal_load = "weight"', "normal_load_N = 20.0")
    assert "normal_load_N = 20.0" in loaded
    system = case_from_text(loaded + law).system
    assert (system.friction.coulomb_coefficient, system.friction.static_coefficient) == (0.15, 0.3)
    assert case_from_text(BENCH + law).system.friction.coulomb_coefficient == pytest.approx(3.0 / (1.5 * 9.80665))
    slope = case_from_text(BENCH + law + "[environment]\ninclination_deg = 60\n").system.friction
    assert slope.coulomb_coefficient == pytest.approx(2.0 * 3.0 / (1.5 * 9.80665))
    with pytest.raises(CaseError, match=r"friction.static_force_N: is a force, which is no coefficient"):
        case_from_text(loaded.replace("normal_load_N = 20.0", 'normal_load = "dynamic"') + law)
    with pytest.raises(CaseError, match=r"friction.coulomb_force_N: is coulomb_coefficient once more"):
        case_from_text(loaded + law + "coulomb_coefficient = 0.1\n")
    with pytest.raises(CaseError, match=r"friction.coulomb_force_N: should be at least 0, got -3"):
        case_from_text(loaded + law.replace("= 3.0", "= -3.0"))
    with pytest.raises(CaseError, match="coulomb_force_N"):
        case_from_text('[machine]\nkind = "oscillator"\n[drive]\nwaveform = "harmonic"\n' + law.replace("_s_per_m", ""))


@pytest.mark.slow
def test_a_contact_that_turns_is_fitted_in_its_own_units(folder, capsys):
    """The same numbers as those of a sliding contact, under the names and units of a turning one."""
    write_record(folder / "turn.csv", header="time [s],omega [rad/s],torque [kN m]", scale=1e-3, seed=1)
    assert command("wide.csv", *STEADY, "--json") == OK
    slid = json.loads(capsys.readouterr().out)
    assert slid["options"]["guessed_units"] == {"time": "s", "velocity": "m/s", "force": "N"}
    assert command("turn.csv", *STEADY, "--json", "--out", "turned") == OK
    turned = json.loads(capsys.readouterr().out)
    assert turned["options"]["guessed_units"] == {}
    for name, value in values(slid).items():
        assert values(turned)[name] == pytest.approx(value, rel=1e-6)
    assert {p["name"]: p["value"]["unit"] if isinstance(p["value"], dict) else "1" for p in turned["parameters"]} == {
        "coulomb_coefficient": "N m", "static_coefficient": "N m", "decay_rate": "s/rad",
    }  # fmt: skip
    assert (turned["rmse"]["unit"], turned["rmse"]["value"]) == ("N m", pytest.approx(slid["rmse"]["value"], rel=1e-6))
    named = {"force_name": "torque", "force": "N m", "displacement": "rad", "velocity": "rad/s"}
    assert turned["units"].items() >= named.items()
    assert "N m, rad, s" in (folder / "turned/friction.toml").read_text()
    assert "velocity_rad_per_s" in (folder / "turned/residuals.csv").read_text()
    assert command("wide.csv", *STEADY) == OK
    assert "files nor settings give them: time in s, velocity in m/s, force in N" in capsys.readouterr().out
    pendulum = ("--pendulum", "mass=1,length=1", "--out", "x", "--load", "2")
    assert "one that turns" in refused(capsys, "turn.csv", *STEADY, *pendulum)
    assert "of one contact" in refused(capsys, "turn.csv", "wide.csv", *STEADY)


@pytest.mark.slow
def test_a_step_of_the_speed_goes_through_the_machines_spring(folder, capsys):
    from vibrocap.identification.spring_fit import Step, _pulled
    from vibrocap.physics.friction.rate_and_state import RateAndStateAgeing

    law = RateAndStateAgeing(
        reference_coefficient=0.6, direct_effect=0.008, evolution_effect=0.009, critical_distance=8e-6,
        reference_velocity=3e-6,
    )  # fmt: skip
    time = np.linspace(0.0, 40.0, 800)
    force = _pulled(law, 1.0, np.array([5000.0]), [Step(0.0, 3e-6), Step(21.0, 1e-5)], time)[0]
    force = force + 3e-4 * np.random.default_rng(0).standard_normal(800)
    displacement = 3e-6 * np.minimum(time, 21.0) + 1e-5 * np.maximum(time - 21.0, 0.0)
    header = "time,displacement,friction"
    np.savetxt("step.csv", np.stack([time, displacement, force], axis=1), delimiter=",", header=header, comments="")
    arguments = ("step.csv", "--law", "rate-and-state-ageing", "--intervals", "covariance", "--starts", 1)
    assert command(*arguments, "--spring", "5000", "--json") == OK
    table = {load["name"]: load for load in json.loads(capsys.readouterr().out)["parameters"]}
    for name in ("direct_effect", "evolution_effect", "critical_distance"):
        low, high = (each["value"] if isinstance(each := table[name][end], dict) else each for end in ("low", "high"))
        assert low < getattr(law, name) < high
    assert command(*arguments, "--spring", "searched", "--out", "fit") == OK
    assert "machine_stiffness" in capsys.readouterr().out
    for spring, words in (("-3", "--spring: should be > 0 N/m"), ("stiff", "--spring stiff: should be measured")):
        assert words in refused(capsys, *arguments, "--spring", spring)
    assert "--spring: is for one law and one record" in refused(capsys, *arguments, "--spring", "5000", "--steady")


@pytest.mark.skipif(not HAS_PICTURES, reason="needs matplotlib")
def test_a_match_is_drawn_with_the_difference_that_remains(tmp_path):
    from vibrocap.identification.experiments.comparison import match
    from vibrocap.identification.experiments.experiment_design import ramp
    from vibrocap.physics.friction.curves import Exponential, Stribeck
    from vibrocap.plotting.fits import match_figure
    from vibrocap.plotting.look.finishing import save

    for over in ({"velocity": (0.01, 1.0)}, {"motion": ramp(0.5, 4.0, 100)}):
        closest = match("exponential", Stribeck(), starts=2, **over)
        axes = match_figure(closest).get_axes()
        assert len(axes) == (4 if "motion" in over else 2)
        remaining = axes[-1].get_lines()[0].get_ydata()
        assert np.abs(remaining).max() == pytest.approx(closest.largest)
        assert closest.largest > 0
    assert save(match_figure(closest), tmp_path / "match.png").stat().st_size > 10_000
    assert isinstance(closest.law, Exponential)


@pytest.mark.slow
def test_a_law_in_the_units_of_a_case_has_the_same_force(folder):
    """Fitted under 2 N and in SI; in a case forces count in the weight and velocities in sqrt(g l)."""
    arguments = ("wide.csv", *STEADY, "--load", 2)
    assert command(*arguments, "--out", "si") == OK
    assert command(*arguments, "--out", "case", "--pendulum", "mass=0.5,length=0.3") == OK
    plain = '[machine]\nkind = "pendulum-capsule"\n[drive]\nwaveform = "harmonic"\n'
    table = {
        name: case_from_text(machine + (folder / name / "friction.toml").read_text()).system.friction
        for name, machine in {"si": BENCH, "case": plain}.items()
    }
    assert (folder / "case/friction.toml").read_text().startswith("# Dimensionless, for a pendulum of 0.5 kg and 0.3 m")
    assert "SI" in (folder / "si/friction.toml").read_text().splitlines()[0]
    speed, weight, root = 0.04, 0.5 * 9.80665, (9.80665 * 0.3) ** 0.5
    expected = table["si"].steady_force(speed / root, 2.0 / weight)  # the bench is of the same pendulum
    assert table["case"].steady_force(speed / root, 2.0 / weight) == pytest.approx(expected, rel=1e-12)
    assert table["case"].decay_rate == pytest.approx(table["si"].decay_rate, rel=1e-12)


def test_the_units_of_a_case_need_the_normal_force_and_a_folder(folder, capsys):
    text = refused(capsys, "wide.csv", *STEADY, "--out", "fit", "--pendulum", "mass=0.5,length=0.3")
    assert "--pendulum: needs the normal force of wide; give it by --load" in text
    text = refused(capsys, "wide.csv", *STEADY, "--load", 2, "--pendulum", "mass=0.5,lenght=0.3")
    assert "--pendulum: is for the friction.toml of --out FOLDER" in text
    assert "should be written as mass=0.5,length=0.3" in text
    text = refused(capsys, "wide.csv", *STEADY, "--load", 2, "--out", "fit", "--pendulum", "mass=0,length=0.3")
    assert "should be numbers > 0" in text
    assert not (folder / "fit").exists()


@pytest.mark.skipif(not HAS_PICTURES, reason="needs matplotlib")
def test_picture_shows_records_and_parameters(folder):
    from vibrocap.plotting.fits import fit_figure, residual_figure
    from vibrocap.records.reading.readers import read_records

    records = read_records(["wide.csv", "narrow.csv"])
    fitted = fits.steady_fit(records, "exponential", held_out="narrow")
    drawn = fit_figure(fitted).get_axes()
    assert [ax.get_title(loc="left").partition(":")[0] for ax in drawn] == ["wide", "narrow", "Parameters"]
    assert "held out" in drawn[1].get_title(loc="left")
    labels = [line.get_label() for line in drawn[1].get_lines()]
    assert "measured" in labels
    assert "predicted (held out)" in labels
    rows = np.array(residual_figure(fitted).get_axes()).reshape(2, 3)
    for (over_time, *_), result in zip(rows, fitted.records, strict=True):
        line = over_time.get_lines()[0]
        assert np.max(np.abs(line.get_ydata())) == pytest.approx(
            1e3 * np.max(np.abs(result.predicted - result.measured))  # errors below 1 N are drawn in mN
        )


@pytest.mark.skipif(not HAS_PICTURES, reason="needs matplotlib")
def test_long_records_are_drawn_by_a_stretch_around_their_fastest():
    from vibrocap.identification.fit_result import RecordResult
    from vibrocap.plotting.fits import MOST_POINTS, _stretch
    from vibrocap.plotting.look.style import decimated

    time = np.linspace(0.0, 100.0, 20_001)
    velocity = np.sin(2 * np.pi * time) * np.where(np.abs(time - 70.0) < 1.0, 2.0, 1.0)
    record = RecordResult("long", False, time, velocity, velocity, velocity, 0.0, 0.0, 1.0)
    stretch = _stretch(record, 8)
    assert time[stretch.stop - 1] - time[stretch.start] == pytest.approx(8.0, abs=0.02)  # two intervals of samples
    assert time[stretch.start] < 69.5
    assert time[stretch.stop - 1] > 70.5
    assert _stretch(record, 100) == slice(0, len(time))
    force = np.zeros(20_001)
    force[7_777] = 1.0
    drawn = decimated(time, force, MOST_POINTS)[1]
    assert drawn.max() == 1.0
    assert len(drawn) <= MOST_POINTS < len(force)


def test_columns_and_units_are_named(folder, capsys):
    write_record(folder / "odd.csv", header="a,b,c", scale=1e-3)
    names = ("--columns", "time=a,velocity=1", "--columns", "force=c", "--units", "force=kN")
    assert command("odd.csv", *STEADY, *names, "--json") == OK
    assert values(json.loads(capsys.readouterr().out))["coulomb_coefficient"] == pytest.approx(COULOMB, rel=0.02)


def test_fixed_parameters_are_held(folder, capsys):
    assert command("wide.csv", *STEADY, "--fixed", f"decay_rate={RATE}", "--json") == OK
    content = json.loads(capsys.readouterr().out)
    assert values(content)["decay_rate"] == RATE
    assert {p["name"]: p["verdict"] for p in content["parameters"]}["decay_rate"] == "held"


def test_loss_and_seed_and_starts_are_passed_on(folder, capsys):
    asked = ("--loss", "soft_l1", "--seed", "3", "--starts", "2", "--intervals", "covariance", "--terms", "offset")
    assert command("wide.csv", *STEADY, *asked, "--json") == OK
    content = json.loads(capsys.readouterr().out)
    assert {k: content["options"][k] for k in ("loss", "seed", "starts", "intervals", "terms")} == {
        "loss": "soft_l1",
        "seed": 3,
        "starts": 2,
        "intervals": "covariance",
        "terms": ["offset"],
    }
    assert [p["name"] for p in content["nuisances"]] == ["offset"]


# --- what is refused, and warned of ----------------------------------------------------------------------------------


def test_every_complaint_comes_at_once(folder, capsys):
    arguments = ("--law", "exponential", "--hold-out", "none", "--fixed", "decay=1", "--fixed", "x", "--plot", "p.jpeg")
    text = refused(capsys, "wide.csv", *arguments, "--out", "wide.csv/fit")
    for words in ("--hold-out: no record", "did you mean 'decay_rate'", "--fixed x: should", "--plot: should end"):
        assert words in text
    assert "--out: " in text
    assert {path.name for path in folder.iterdir()} == {"wide.csv", "narrow.csv"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--law", "exponental"), "--law: no law is called 'exponental'; did you mean 'exponential'?"),
        ((), "--law: give one law, or several with --compare"),
        (("--law", "dahl", "--compare", "dahl"), "--law: give one law"),
        (("--compare", "dahl", "--steady"), "--steady: is for --law"),
        ((*STEADY, "--loss", "square"), "--loss: should be one of linear"),
        ((*STEADY, "--starts", "0"), "--starts: should be a whole number"),
        ((*STEADY, "--hold-out", "w*"), "--hold-out: leaves no record to fit"),
        ((*STEADY, "--free", "decay_rate", "--fixed", "decay_rate=1"), "--free: decay_rate is also in fixed"),
        ((*STEADY, "--fixed", "coulomb_coefficient=-1"), "--fixed: coulomb_coefficient should be at least 0, got -1.0"),
        (
            (*STEADY, "--fixed", "static_coefficient=1,coulomb_coefficient=2"),
            "--fixed: static_coefficient should be at",
        ),
        ((*STEADY, "--over", "coulomb_coefficient=1-2"), "--over should be PATH=LEAST:LARGEST"),
        ((*STEADY, "--over", "coulomb=1:2"), "--over: exponential has no parameter 'coulomb'"),
        (
            (*STEADY, "--over", "coulomb_coefficient=2:1"),
            "--over: coulomb_coefficient should have its lower bound first",
        ),
        ((*STEADY, "--terms", "weight"), "--terms: there is no term 'weight'; "),
        (("--law", "rate-and-state-slip", "--spring", "measured", "--terms", "mass"), "--terms: are for fits without"),
        ((*STEADY, "--columns", "force=f2"), "f2"),
        ((*STEADY, "--design", "amplitude=0.1:1"), "--design should have 0 < LOW < HIGH of both"),
        ((*STEADY, "--bootstrap", "9"), "--bootstrap: should be a whole number >= 10"),
        ((*STEADY, "--prior", "mass=95+-1"), "--prior: is for fits without --steady and --spring"),
        (("--law", "coulomb", "--prior", "mass=95"), "--prior mass=95: should be NAME=MEAN+-DEVIATION"),
        ((*STEADY, "--terms", "search"), "--terms: search is for --law, without --steady and --spring"),
        ((*STEADY, "--report"), "--report: should be left out without --out"),
        ((*STEADY, "--cutoff", "1e6"), "cutoff: should be"),
        ((*STEADY, "--least-speed", "1"), "samples faster than 1 m/s"),
    ],
)
def test_wrong_settings_are_refused(folder, capsys, arguments, words):
    assert words in refused(capsys, "wide.csv", *arguments)


def test_bounds_of_a_parameter_hold_it(folder, capsys):
    assert command("wide.csv", *STEADY, "--over", "coulomb_coefficient=0.01:0.02", "--json") == 0
    content = json.loads(capsys.readouterr().out)
    (level,) = [each for each in content["parameters"] if each["name"] == "coulomb_coefficient"]
    assert 0.01 <= level["value"]["value"] <= 0.02


def test_files_are_needed_and_given_once(folder, capsys):
    assert "DATA: give at least one file" in refused(capsys, *STEADY)
    assert "DATA: wide.csv is given twice" in refused(capsys, "wide.csv", "wide.csv", *STEADY)
    assert "none.csv: no such file" in refused(capsys, "none.csv", *STEADY)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda rows: [*rows[:9], "0.1,inf,0.3", *rows[10:]], "1 infinite"),
        (lambda rows: rows[:2], "at least 8 samples"),
        (lambda rows: [rows[0], *reversed(rows[1:])], "time: runs backwards"),
        (lambda rows: [rows[0], *(f"{i},{i % 3},1.5" for i in range(50))], "force: is 1.5 at all 50 samples"),
        (lambda rows: ["time,speeed", *(row.rpartition(",")[0] for row in rows[1:])], "force: no column"),
    ],
)
def test_bad_data_get_a_message_and_not_a_number(folder, capsys, spoil, words):
    rows = (folder / "wide.csv").read_text().splitlines()
    (folder / "bad.csv").write_text("\n".join(spoil(rows)) + "\n")
    assert words in refused(capsys, "bad.csv", *STEADY)


def test_units_that_look_wrong_are_warned_of(folder, capsys):
    assert command("wide.csv", *STEADY, "--load", "4e4") == OK
    assert "warning: record 'wide': force, normal_force: imply a friction coefficient" in capsys.readouterr().err


def test_a_fit_without_a_law_is_incomplete(folder, capsys, monkeypatch):
    def failed(*arguments, **settings):
        status, nothing = SearchStatus.FAILED, float("nan")
        numbers = (nothing, nothing, nothing, 400, nothing, nothing, nothing)
        return Fit(None, "exponential", status, (), (), (), *numbers, None, (), 0.0, {})

    monkeypatch.setattr(fits, "steady_fit", failed)
    text = refused(capsys, "wide.csv", *STEADY, "--out", "fit", "--plot", "fit.png", code=INCOMPLETE)
    assert "No fit of exponential: no start could be driven" in text
    assert {path.name for path in folder.iterdir()} == {"wide.csv", "narrow.csv"}


def test_faults_of_our_own_are_not_taken_for_wrong_input(folder, monkeypatch):
    def broken(*arguments, **settings):
        raise ValueError("operands could not be broadcast")

    monkeypatch.setattr(fits, "steady_fit", broken)
    with pytest.raises(ValueError, match="broadcast"):
        command("wide.csv", *STEADY)


# --- laws that are driven --------------------------------------------------------------------------------------------


def test_what_is_known_beforehand_and_differs_between_records(folder, capsys):
    law = ("wide.csv", "narrow.csv", "--law", "exponential", "--starts", "1", "--intervals", "covariance", "--json")
    assert command(*law, "--terms", "offset", "--by-record", "offset", "--prior", "offset=0.001+-0.0001") == OK
    table = {load["name"]: load for load in json.loads(capsys.readouterr().out)["nuisances"]}
    # the data alone tell it to some thousandths
    assert bare(table["offset"]["value"]) == pytest.approx(0.001, abs=2e-4)
    assert table["offset"]["verdict"] == "as known beforehand: the prior outweighs the data"
    assert abs(bare(table["offset[narrow]"]["value"])) < 0.02
    assert command(*law, "--terms", "search") == OK
    assert json.loads(capsys.readouterr().out)["terms"]["terms"] == []


@pytest.mark.slow
def test_samples_are_written_for_robust(folder, capsys):
    pytest.importorskip("emcee")
    law = ("wide.csv", *STEADY, "--intervals", "covariance", "--posterior", "100", "--out", "new")
    assert command(*law) == OK
    record = json.loads((folder / "new" / "posterior.json").read_text(encoding="utf-8"))
    assert record["law_name"] == "exponential"
    assert np.shape(record["values"]) == (100, len(record["names"]))
    assert "of 100 samples" in capsys.readouterr().out


def test_the_help_names_every_term():
    assert ", ".join((*(name for name, term in TERMS.items() if not term.wave), *BESIDE)) == TERM_NAMES
