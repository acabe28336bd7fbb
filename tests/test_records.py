"""A measured record: what it refuses, what it warns of, its slices."""

import pickle
import warnings

import numpy as np
import pytest

from vibrocap.records.record import Record, RecordError, RecordWarning

N = 200
TIME = np.linspace(0.0, 2.0, N)
VELOCITY = 0.3 * np.cos(5.0 * TIME)
DISPLACEMENT = 0.06 * np.sin(5.0 * TIME)
FORCE = 40.0 * np.tanh(VELOCITY / 0.01)


def record(**changes) -> Record:
    fields = {"name": "made", "time": TIME, "force": FORCE, "velocity": VELOCITY, "displacement": DISPLACEMENT}
    return Record(**{**fields, **changes})


def with_value(values, at, value):
    changed = np.array(values)
    changed[at] = value
    return changed


# --- what a good record holds -----------------------------------------------------------------------------------------


def test_a_record_keeps_what_it_was_given_and_cannot_be_written_to():
    force = FORCE.copy()
    entry = record(force=force, normal_force=100)
    force[0] = 7.0
    np.testing.assert_array_equal(entry.force, FORCE)
    assert entry.normal_force == 100.0
    assert entry.acceleration is None
    with pytest.raises(ValueError, match="read-only"):
        entry.force[0] = 1.0


def test_lists_and_single_precision_become_doubles():
    entry = record(time=TIME.tolist(), force=FORCE.astype(np.float32))
    assert entry.time.dtype == entry.force.dtype == np.float64


def test_sampling():
    entry = record()
    assert len(entry) == N
    assert entry.even
    assert entry.duration == 2.0
    assert entry.interval == pytest.approx(2.0 / (N - 1), rel=1e-12)
    assert entry.sampling_rate == pytest.approx((N - 1) / 2.0, rel=1e-12)
    late = with_value(TIME, 50, TIME[50] + 0.02 * entry.interval)
    assert not record(time=late).even
    assert record(time=with_value(TIME, 50, TIME[50] + 0.005 * entry.interval)).even


def test_between_keeps_the_samples_within_ends_included():
    made = record(normal_force=np.linspace(90.0, 110.0, N)).between(TIME[10], TIME[60])
    np.testing.assert_array_equal(made.time, TIME[10:61])
    np.testing.assert_array_equal(made.displacement, DISPLACEMENT[10:61])
    np.testing.assert_array_equal(made.normal_force, np.linspace(90.0, 110.0, N)[10:61])
    assert made.name == "made"
    with pytest.raises(ValueError, match=r"start, stop should .* 0.1005\d* to 0.6030\d* s, got 5 to 6"):
        made.between(5.0, 6.0)


def test_thinned_keeps_every_nth_sample():
    thinned = record(normal_force=100.0).thinned(3)
    np.testing.assert_array_equal(thinned.force, FORCE[::3])
    assert thinned.normal_force == 100.0
    for every in (0, -1, 1.5, True):
        with pytest.raises(ValueError, match="every should be a whole number >= 1"):
            record().thinned(every)


def test_what_is_too_short_after_slicing_is_refused():
    with pytest.raises(RecordError, match="time: should have at least 8 samples, got 5 samples"):
        record().between(TIME[0], TIME[4])


def test_a_record_is_pickled_whole():
    content = pickle.loads(pickle.dumps(record(conditions={"mass_kg": 2})))
    np.testing.assert_array_equal(content.force, FORCE)
    assert content.conditions == {"mass_kg": 2.0}


def test_words():
    assert repr(record()) == "Record('made': 200 samples in 2 s, 99.5 Hz; force, velocity, displacement)"


def test_replaced_refuses_an_unknown_field():
    with pytest.raises(TypeError, match="no field 'speed'"):
        record().replaced(speed=1)


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"force": with_value(FORCE, [17, 40], np.nan)}, ["force: 2 NaN of 200 values, the first at index 17"]),
        ({"velocity": with_value(VELOCITY, 3, np.inf)}, ["velocity: 1 infinite of 200 values, the first at index 3"]),
        (
            {"force": with_value(with_value(FORCE, 9, np.nan), 5, np.inf), "time": with_value(TIME, 2, np.nan)},
            ["time: 1 NaN of 200", "force: 1 NaN and 1 infinite of 200 values, the first at index 5"],
        ),
        ({"normal_force": np.nan}, ["normal_force: 200 NaN"]),
        (
            {"time": with_value(TIME, 30, TIME[28])},
            ["time: runs backwards at index 30: 0.2814070352 after 0.2914572864"],
        ),
        (
            {"time": with_value(TIME, 30, TIME[29])},
            ["time: repeats at index 30: ... or give the sampling rate"],
        ),
        ({"time": TIME[::-1]}, ["time: runs backwards at index 1 (199 such places)"]),
        ({"force": 3.0 + 1e-15 * FORCE}, ["force: is 3 at all 200 samples"]),
        ({"force": np.full(N, 3.0)}, ["force: is 3 at all 200 samples; a constant force determines nothing"]),
        (
            {"velocity": np.full(N, 0.1), "displacement": np.zeros(N)},
            ["velocity: is 0.1 at all 200", "displacement: is 0 at all 200"],
        ),
        ({"force": FORCE[:-1]}, ["time, force, velocity, displacement: should have one value for each ... force 199"]),
        ({"velocity": None, "displacement": None}, ["velocity, displacement: neither is given"]),
        ({"time": None}, ["time: is missing"]),
        ({"force": None}, ["force: is missing"]),
        ({"force": FORCE.reshape(-1, 1)}, ["force: should be one column of numbers, got an array of shape (200, 1)"]),
        ({"force": 3.0}, ["force: should be one column of numbers, got a single number"]),
        ({"force": ["a"] * N}, ["force: should be numbers, got ['a', 'a'"]),
        ({"normal_force": -5.0}, ["normal_force: should be at least 0 ... got -5 at index 0"]),
        ({"normal_force": 0.0}, ["normal_force: should be greater than 0 somewhere"]),
    ],
)
def test_bad_data_gets_a_message(changes, said):
    with pytest.raises(RecordError) as caught:
        record(**changes)
    assert caught.value.source == "record 'made'"
    assert len(caught.value.complaints) == len(said)
    for complaint, words in zip(caught.value.complaints, said, strict=True):
        assert complaint in str(caught.value)
        for part in words.split(" ... "):
            assert part in complaint


@pytest.mark.parametrize("count", [0, 1, 7])
def test_too_few_samples(count):
    with pytest.raises(RecordError, match=f"at least 8 samples, got {count} sample"):
        Record("short", time=TIME[:count], force=VELOCITY[:count], velocity=VELOCITY[:count])
    assert len(Record("enough", time=TIME[:8], force=VELOCITY[:8], velocity=VELOCITY[:8])) == 8


# --- what is warned of ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"displacement": 1e3 * DISPLACEMENT}, "displacement looks as if it were in mm, not m"),
        ({"displacement": 1e6 * DISPLACEMENT}, "displacement looks as if it were in um, not m"),
        ({"velocity": 1e3 * VELOCITY}, "velocity looks as if it were in mm/s, not m/s, or time as if it were in ms"),
        ({"time": 1e3 * TIME}, "velocity looks as if it were in mm/s, not m/s, or time as if it were in ms"),
        ({"displacement": -1e3 * DISPLACEMENT}, "opposite directions; displacement looks as if it were in mm"),
        ({"displacement": -DISPLACEMENT}, "displacement is -1 times the integral of velocity; they count in opposite"),
        ({"displacement": 60.0 * DISPLACEMENT}, "displacement is 60 times the integral of velocity; check their units"),
        ({"normal_force": 1.0}, "imply a friction coefficient of 39.* outside 0.001 to 10"),
        ({"normal_force": 1e6}, "imply a friction coefficient of 3.9.*e-05"),
        ({"normal_force": np.linspace(0.5, 1.5, N)}, "imply a friction coefficient of 39"),
    ],
)
def test_a_unit_that_looks_wrong_is_warned_of(changes, said):
    with pytest.warns(RecordWarning, match=said):
        record(**changes)


def test_good_units_are_not_warned_of():
    """Noise, a drifting velocity sensor and a coefficient near the edge are no slip in the units."""
    rng = np.random.default_rng(1)
    noisy = DISPLACEMENT + 0.02 * rng.standard_normal(N)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        record(displacement=noisy)
        record(velocity=VELOCITY + 0.02, normal_force=100.0)
        record(displacement=2.5 * DISPLACEMENT)
        record(displacement=rng.standard_normal(N))  # unrelated: no factor can be told
        record(normal_force=39.0 / 9.0)
        record(normal_force=39.0 / 0.0011)


def test_slices_are_not_warned_of_again():
    with pytest.warns(RecordWarning) as caught:
        record(normal_force=1.0).thinned(2).between(0.0, 1.0)
    assert len(caught) == 1
