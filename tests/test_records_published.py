"""The published data sets: read as they are here, and in the layout of their originals, which is made here."""

import numpy as np
import pytest
from scipy.io import savemat

from published_data import published_folder
from vibrocap.records.preparation import prepared
from vibrocap.records.published import basalt_velocity_step, data_folder, emps, paper_stick_slip, rotary_damper
from vibrocap.records.reading.readers import read_records
from vibrocap.records.record import RecordError


def test_rotary_damper():
    records = rotary_damper(published_folder("arts-rotary-damper"))
    assert [(record.name, len(record)) for record in records] == [
        ("harmonic_02", 14337),
        ("harmonic_07", 14337),
        ("harmonic_08", 7169),
        ("harmonic_11", 14337),
        ("eq_KocaeliMCE_window", 8192),
    ]
    for entry in records:
        assert entry.even
        assert entry.sampling_rate == pytest.approx(1024.0, rel=1e-9)
        assert 14e3 < entry.force.max() < 21e3
        assert -24e3 < entry.force.min() < -19e3
    peaks = [1e3 * np.max(np.abs(record.displacement)) for record in records[:4]]
    assert peaks == pytest.approx([19, 39, 39, 59], abs=1.0)
    # Their velocity is a derivative of their displacement; ours agrees to the float32 in which it is kept.
    derived = prepared(records[0].replaced(velocity=None), cutoff=50.0)
    error = derived.velocity[200:-200] - records[0].velocity[200:-200]
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.sqrt(np.mean(records[0].velocity ** 2))


def test_paper_stick_slip():
    records = {each.name: each for each in paper_stick_slip(published_folder("paper-stick-slip"))}
    lengths = {"k168_v42": 80000, "k168_v1100": 28721, "k168_v4300": 7521}
    lengths |= {"k1002_v42": 80000, "k1002_v1100": 28641, "k1002_v4300": 7521}
    assert {name: len(record) for name, record in records.items()} == lengths
    slow = records["k168_v42"]
    assert slow.conditions["pulling_speed_m_per_s"] == 42e-6
    assert slow.normal_force == pytest.approx(30.7e-3 * 9.81, rel=1e-12)
    assert slow.sampling_rate == pytest.approx(2000.0, rel=1e-9)
    assert np.mean(slow.force) / slow.normal_force == pytest.approx(0.3283, abs=1e-4)
    # On the whole the slider goes as far as its spring is pulled; and where it sticks, the spring stretches by V t.
    assert slow.displacement[-1] == pytest.approx(42e-6 * 40.0, rel=0.1)
    half_a_second = 1000
    stretched = np.median(slow.force[half_a_second:] - slow.force[:-half_a_second])
    assert stretched == pytest.approx(168 * 42e-6 * 0.5, rel=0.1)


def test_basalt_velocity_step():
    (record,) = basalt_velocity_step(published_folder("basalt-velocity-step"))
    assert len(record) == 5849
    assert record.time[0] == 0.0
    assert not record.even
    assert record.normal_force == 1.0
    assert record.force[0] == 0.607016
    assert record.conditions["normal_stress_Pa"] == pytest.approx(19.967e6, rel=1e-4)
    speed = prepared(record, cutoff=0.2).velocity
    assert np.median(speed[record.time < 60.0]) == pytest.approx(3e-6, rel=1e-3)
    assert np.median(speed[record.time > 80.0]) == pytest.approx(10e-6, rel=1e-3)


def test_basalt_through_the_ordinary_reader():
    (record,) = read_records(published_folder("basalt-velocity-step") / "basalt_velocity_step.txt")
    assert record.displacement[0] == pytest.approx(8503.602e-6, rel=1e-12)
    assert "displacement: column 'Displ(microns)' in um (guessed from its name)" in record.notes
    assert "normal_force: column 'Normal_stress(MPa)' (guessed from its name) is not used" in record.notes
    assert "force: the coefficient for a load of 1 N" in record.notes


# --- the layout of the originals --------------------------------------------------------------------------------------

RNG = np.random.default_rng(5)
COUNT = 16000
SWEEP = np.sin(np.linspace(0.0, 60.0, COUNT))


def test_originals_of_the_rotary_damper(tmp_path):
    for part, scale in (("F", 2e4), ("x", 0.02), ("v", 0.3)):
        (tmp_path / part).mkdir()
        for number in (2, 10):
            np.save(tmp_path / part / f"test{number}.npy", (scale * SWEEP + number).reshape(-1, 1))
    (tmp_path / "v" / "test2.npay.npy").write_bytes(b"")  # such stand beside them
    (tmp_path / "validation").mkdir()
    table = np.column_stack([np.arange(COUNT) / 1024.0, 1e4 * SWEEP, 0.01 * SWEEP, 0.1 * SWEEP])
    np.save(tmp_path / "validation" / "KocaeliMCE.npy", table)
    records = rotary_damper(tmp_path)
    assert [record.name for record in records] == ["harmonic_02", "harmonic_10", "eq_KocaeliMCE_window"]
    np.testing.assert_array_equal(records[1].force, 2e4 * SWEEP + 10)
    np.testing.assert_array_equal(records[2].velocity, 0.1 * SWEEP[6144:14336])
    assert records[2].time[1] == 1.0 / 1024.0


def test_originals_of_paper_on_paper(tmp_path):
    (tmp_path / "data_raw").mkdir()
    pull = 0.3 + 0.05 * SWEEP
    savemat(tmp_path / "data_raw" / "k2254Nm_v1100.mat", {"Fnorm": pull.reshape(-1, 1), "t": np.arange(COUNT) / 2e3})
    (record,) = paper_stick_slip(tmp_path)
    weight = 30.7e-3 * 9.81
    assert record.name == "k2254_v1100"
    np.testing.assert_allclose(record.force, weight * pull, rtol=1e-15)
    slider = 1100e-6 - weight / 2254.0 * np.gradient(pull, record.time)  # the equation of the paper
    np.testing.assert_allclose(np.gradient(record.displacement, record.time), slider, rtol=1e-9)
    savemat(tmp_path / "data_raw" / "k2254Nm_v1100.mat", {"F": pull})
    with pytest.raises(RecordError, match="Fnorm: no such variable; there is 'F'"):
        paper_stick_slip(tmp_path)


MASS, GAIN, NOISE = 95.1, 35.15, 2e-7
TIME = np.arange(8000) / 1000.0
POSITION = 0.12 * np.sin(1.6 * TIME) + 0.01 * np.sin(9.0 * TIME)
SPEED = 0.192 * np.cos(1.6 * TIME) + 0.09 * np.cos(9.0 * TIME)
ACCELERATION = -0.12 * 1.6**2 * np.sin(1.6 * TIME) - 0.81 * np.sin(9.0 * TIME)
FRICTION = 203.5 * SPEED + 20.4 * np.tanh(SPEED / 0.002)


@pytest.fixture
def emps_file(tmp_path):
    """A file laid out as DATA_EMPS.mat: t, qm, qg, vir as columns, gtau a number."""
    measured = POSITION + NOISE * RNG.standard_normal(len(TIME))
    volts = (MASS * ACCELERATION + FRICTION) / GAIN
    columns = {"t": TIME, "qm": measured, "qg": POSITION, "vir": volts}
    path = tmp_path / "DATA_EMPS.mat"
    savemat(path, {**{name: values.reshape(-1, 1) for name, values in columns.items()}, "gtau": GAIN})
    return path


def test_emps(emps_file):
    """Noise of the velocity as the filter lets it through; of the acceleration, with u^4 for u^2 under the integral."""
    (record,) = emps(emps_file)
    inner = slice(500, -500)
    np.testing.assert_allclose(record.force, MASS * ACCELERATION + FRICTION, rtol=1e-12, atol=1e-9)
    assert record.name == "EMPS"
    noise = 0.729 * NOISE * 2 * np.pi * 100.0 * np.sqrt(0.1)
    error = np.sqrt(np.mean((record.velocity - SPEED)[inner] ** 2))
    assert error == pytest.approx(noise, rel=0.1)  # the bilinear transform lowers it by some 3 % at a tenth of the rate
    noise = np.sqrt(2 * 0.1 * 0.1624) * NOISE * (2 * np.pi * 100.0) ** 2
    error = np.sqrt(np.mean((record.acceleration - ACCELERATION)[inner] ** 2))
    assert error == pytest.approx(noise, rel=0.15)
    (record,) = emps(emps_file, mass=MASS, cutoff=30.0)
    error = np.sqrt(np.mean((record.force - FRICTION)[inner] ** 2))
    assert error < 2.0 * MASS * np.sqrt(2 * 0.03 * 0.1624) * NOISE * (2 * np.pi * 30.0) ** 2


def test_emps_from_its_folder(emps_file):
    (emps_file.parent / "more").mkdir()
    without = {"t": TIME, "qm": POSITION, "qg": POSITION, "vir": SPEED}
    savemat(emps_file.parent / "more" / "DATA_EMPS_PULSES.mat", without)
    first, pulses = emps(emps_file.parent)
    assert (first.name, pulses.name) == ("EMPS", "EMPS_PULSES")
    np.testing.assert_allclose(pulses.force, GAIN * SPEED, rtol=1e-12)
    with pytest.raises(RecordError, match="gtau: no such variable; there is 't', 'qm', 'qg', 'vir'"):
        emps(emps_file.parent / "more" / "DATA_EMPS_PULSES.mat")


def test_data_that_is_not_here(tmp_path, monkeypatch):
    monkeypatch.setenv("VIBROCAP_DATA", str(tmp_path))
    with pytest.raises(
        FileNotFoundError, match=r"no such folder.*'rotary-damper'.*vibrocap list datasets --fetch rotary-damper"
    ):
        rotary_damper()
    assert data_folder("emps", tmp_path) == tmp_path
    for read in (rotary_damper, paper_stick_slip, basalt_velocity_step, emps):
        with pytest.raises(FileNotFoundError, match="holds no such data; should hold"):
            read(tmp_path)
    monkeypatch.delenv("VIBROCAP_DATA")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "vibrocap" / "data" / "emps").mkdir(parents=True)
    assert data_folder("emps") == tmp_path / "vibrocap" / "data" / "emps"
