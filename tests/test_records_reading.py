"""Records from files: columns, units, layouts, and what is said of files that cannot be read."""

import io
import json
import re
import sys
import warnings

import numpy as np
import pytest

from vibrocap.records.reading import matlab
from vibrocap.records.reading.columns import quantity_of
from vibrocap.records.reading.readers import read_records
from vibrocap.records.reading.units import DIMENSIONS, QUANTITIES, si_unit, unit_named
from vibrocap.records.record import RecordError, RecordWarning

N = 12
TIME = np.linspace(0.0, 1.1, N)
VELOCITY = 0.3 * np.cos(5.0 * TIME)
DISPLACEMENT = 0.06 * np.sin(5.0 * TIME)
FORCE = 40.0 * np.sin(5.0 * TIME + 0.3)
GOOD = {"t": TIME, "F": FORCE, "v": VELOCITY, "x": DISPLACEMENT}


def csv(columns, delimiter=",", header=True, before="", units=None) -> str:
    rows = [delimiter.join(columns)] if header else []
    rows += [delimiter.join(units)] if units else []
    rows += [delimiter.join(repr(float(value)) for value in row) for row in zip(*columns.values(), strict=True)]
    return before + "\n".join(rows) + "\n"


@pytest.fixture
def written(tmp_path):
    def write(text, name="data.csv", **settings):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_records(path, **settings)

    return write


def refused(call, *arguments, **settings) -> str:
    with pytest.raises(RecordError) as caught:
        call(*arguments, **settings)
    return str(caught.value)


def assert_good(made, exact=False):
    for field, values in (("time", TIME), ("force", FORCE), ("velocity", VELOCITY), ("displacement", DISPLACEMENT)):
        np.testing.assert_allclose(getattr(made, field), values, rtol=0.0 if exact else 1e-14, atol=1e-300)


# --- text -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", " ", ", ", " ; "])
@pytest.mark.parametrize("before", ["", "# a rig\n% of ours\n", "Instrument 7\nrun, today\n\n"])
def test_delimiters_and_what_stands_before_the_header(written, delimiter, before):
    (made,) = written(csv(GOOD, delimiter, before=before))
    assert_good(made, exact=True)
    assert made.name == "data"
    assert made.source.endswith("data.csv")


@pytest.mark.parametrize("ends", ["\r\n", "\r\n\r\n"])
def test_line_ends_byte_order_marks_and_quotes(written, ends):
    text = csv({f'"{name}"': values for name, values in GOOD.items()}).replace("\n", ends)
    assert_good(written(b"\xef\xbb\xbf" + text.encode())[0])


@pytest.mark.parametrize(
    "text",
    [
        csv(GOOD).encode("utf-16"),
        csv(GOOD).replace("\n", "\r").encode(),
        csv(GOOD, header=False, before="t [s]   F [N]  v (m/s) x\n").replace(",", " "),
        csv(GOOD) + "\nEnd of the run\n[EOF]\n",
        "\n".join(f"{row or ''},{line}" for row, line in enumerate(csv(GOOD).splitlines())),  # an index without a name
    ],
    ids=["two bytes a character", "line ends of old", "units in brackets", "words behind", "index"],
)
def test_text_as_programs_write_it(written, text):
    assert_good(written(text)[0])


def test_decimal_commas(written):
    commas = csv(GOOD, ";").replace(".", ",")
    dated = "\n".join(f"{'01.03.2026' if row else 'date'};{line}" for row, line in enumerate(commas.splitlines()))
    quoted = "\n".join(",".join(f'"{cell}"' for cell in line.split(";")) for line in commas.splitlines())
    for text in (commas, dated, quoted, commas.replace(";", "   ")):
        assert_good(written(text)[0])


def test_commas_and_points_of_thousands_are_not_taken_for_decimal_ones(written):
    lines = csv({**GOOD, "x": np.arange(60.0, 60.0 + N)}, ";").replace(".", ",").splitlines() * 6
    lines[3] = "0,2;1.234;0,5;1,0"
    assert "line 4, column 'F': '1.234 among decimal commas' is no number" in refused(written, "\n".join(lines))
    thousands = "\n".join(f'{at},"{at + 1},{at + 100}",{at % 7}' for at in range(12))
    assert "'1,100' is no number" in refused(written, f"t,F,v\n{thousands}")
    assert "'0,5' is no number" in refused(written, "t;F;v\n" + "\n".join(f"{at};0,5;{at}.5" for at in range(12)))


def test_a_header_in_a_comment_as_numpy_writes_it(written):
    text = io.StringIO()
    np.savetxt(text, np.column_stack(list(GOOD.values())), header="t F v x", fmt="%.17g")
    assert_good(written(text.getvalue(), "data.txt")[0])


def test_a_line_of_units(written):
    columns = {"t": 1e3 * TIME, "F": 1e-3 * FORCE, "v": 1e3 * VELOCITY, "x": 1e3 * DISPLACEMENT}
    for units in (["ms", "kN", "mm/s", "mm"], ["[ms]", "[kN]", "[mm/s]", "[mm]"]):
        assert_good(written(csv(columns, units=units))[0])


def test_without_a_header_the_places_are_given(written):
    text = csv(GOOD, header=False)
    assert_good(written(text, columns={"time": 0, "force": 1, "velocity": 2, "displacement": 3})[0])
    said = refused(written, text)
    assert "force: no column has a usual name" in said
    assert "the file has no header; its columns are counted from 0 to 3" in said
    assert "columns: force:" in refused(written, text, columns={"time": 0, "force": 4, "velocity": 2})


def test_a_column_of_records(written):
    rows = csv(GOOD).splitlines()
    text = "\n".join(["record," + rows[0], *("one," + row for row in rows[1:]), *("two," + row for row in rows[1:])])
    one, two = written(text)
    assert (one.name, two.name) == ("one", "two")
    assert_good(one)
    assert_good(two)
    run = text.replace("record", "run", 1)
    assert [made.name for made in written(run, columns={"record": "run"})] == ["one", "two"]
    assert "columns: record: no column 'runs'; there is 'run', 't'" in refused(written, run, columns={"record": "runs"})


def test_several_files(tmp_path):
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(csv(GOOD))
    records = read_records([tmp_path / "a.csv", tmp_path / "b.csv"])
    assert [record.name for record in records] == ["a", "b"]
    assert read_records(tmp_path / "a.csv", name="mine")[0].name == "mine"
    assert "name: is for one record, but there are 2" in refused(
        read_records, [tmp_path / "a.csv", tmp_path / "b.csv"], name="mine"
    )
    assert "got an empty list" in refused(read_records, [])


# --- columns and units ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("heading", "meant"),
    [
        ("t", ("time", None)),
        ("Time(s)", ("time", "s")),
        ("time_ms", ("time", "ms")),
        ("F", ("force", None)),
        ("force [kN]", ("force", "kN")),
        ("force_N", ("force", "N")),
        ("Friction", ("force", None)),
        ("mu", ("force", None)),
        ("x", ("displacement", None)),
        ("displacement_mm", ("displacement", "mm")),
        ("Displ(microns)", ("displacement", "um")),
        ("pos [µm]", ("displacement", "um")),
        ("x/mm", ("displacement", "mm")),
        ("v", ("velocity", None)),
        ("vel_m_per_s", ("velocity", "m/s")),
        ("velocity_m_s", ("velocity", "m/s")),
        ("Velocity (mm/s)", ("velocity", "mm/s")),
        ("vel [um s-1]", ("velocity", "um/s")),
        ("SPEED [MM/S]", ("velocity", "mm/s")),
        ("acc [m/s²]", ("acceleration", "m/s^2")),
        ("acceleration_m_per_s2", ("acceleration", "m/s^2")),
        ("normal_force", ("normal_force", None)),
        ("Normal_stress(MPa)", ("normal_force", "MPa")),
        ("F_N", ("force", "N")),
        ("temperature", None),
        ("v_N", None),
        ("v_c", None),  # not the speed of light
        ("Torque [N.m]", ("torque", "N m")),
        ("angle_deg", ("angle", "deg")),
        ("speed [RPM]", ("velocity", "rpm")),
    ],
)
def test_usual_names(heading, meant):
    quantity, unit, _ = quantity_of(heading) or (None, None, 0)
    assert (quantity, unit and unit.name) == (meant or (None, None))


def test_what_was_guessed_is_said(written):
    (made,) = written(csv({"Time (s)": TIME, "Load [kN]": FORCE, "vel": VELOCITY}), columns={"force": "load"})
    assert made.notes == (
        "force: column 'Load [kN]' in kN",
        "time: column 'Time (s)' in s (guessed from its name)",
        "velocity: column 'vel' in m/s (guessed from its name); no unit given, SI assumed",
    )
    np.testing.assert_allclose(made.force, 1e3 * FORCE, rtol=1e-15)


def test_normal_force_among_the_columns(written):
    (made,) = written(csv({**GOOD, "F_N": np.linspace(90, 100, N)}))
    np.testing.assert_array_equal(made.normal_force, np.linspace(90, 100, N))
    assert_good(made)
    (made,) = written(csv({"t": TIME, "F_N": FORCE, "v": VELOCITY}))
    assert made.normal_force is None
    np.testing.assert_array_equal(made.force, FORCE)
    assert written(csv(GOOD), normal_force=50.0)[0].normal_force == 50.0


def test_a_coefficient_is_multiplied_by_the_normal_force(written):
    columns = {"t": TIME, "mu": 0.01 * FORCE, "v": VELOCITY}
    (made,) = written(csv(columns))
    assert made.normal_force == 1.0
    np.testing.assert_allclose(made.force, 0.01 * FORCE, rtol=1e-15)
    load = np.linspace(90.0, 100.0, N)
    np.testing.assert_allclose(written(csv({**columns, "Fn": load}))[0].force, 0.01 * FORCE * load, rtol=1e-15)
    (made,) = written(csv(columns), normal_force=50.0)
    np.testing.assert_allclose(made.force, 0.5 * FORCE, rtol=1e-15)
    assert "force: the coefficient for a load of 50 N" in made.notes


def test_stresses_need_the_area(written):
    columns = {"t": TIME, "shear stress [MPa]": FORCE, "normal stress [MPa]": np.full(N, 80.0), "v": VELOCITY}
    said = refused(written, csv(columns, ","))
    assert said.count("area: is missing") == 2
    (made,) = written(csv(columns), area=1e-4)
    np.testing.assert_allclose(made.force, 100.0 * FORCE, rtol=1e-14)
    np.testing.assert_allclose(made.normal_force, 8000.0, rtol=1e-14)


def test_time_from_a_rate(written):
    columns = {"F": FORCE, "v": VELOCITY}
    for setting in ({"dt": 0.1}, {"sampling_rate": 10.0}):
        (made,) = written(csv(columns), **setting)
        np.testing.assert_allclose(made.time, TIME, rtol=1e-14, atol=1e-15)
    assert (
        "columns: time: no column has a usual name; name it, or give dt (any, for a law that knows no rate"
        in refused(written, csv(columns))
    )
    assert "give one of them, got both" in refused(written, csv(columns), dt=0.1, sampling_rate=10.0)
    assert "dt: should be a number greater than 0, got -1" in refused(written, csv(columns), dt=-1)
    assert "columns names one" in refused(written, csv(GOOD), dt=0.1, columns={"time": "t"})


def test_units_table_is_consistent():
    assert set(DIMENSIONS) == {dim for dims in QUANTITIES.values() for dim in dims}
    for dimension, units in DIMENSIONS.items():
        for unit in units:
            named = unit_named(unit)
            assert named is not None
            assert (named.name, named.dimension) == (unit, dimension)
            assert (named.factor == 1.0) == (unit == units[0])  # the SI unit stands first
    for quantity in QUANTITIES:
        assert si_unit(quantity).dimension == QUANTITIES[quantity][0]


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        *((text, text) for text in ("mN", "MN", "nm")),
        *(("KN", "kN"), ("Kips", "kip"), ("Newtons", "N"), ("°", "deg"), ("°/s", "deg/s"), ("rev/min", "rpm")),
        *((text, "N m") for text in ("Nm", "N-m", "N.m", "N·m", "N m", "N*m")),
        *(("kNm", "kN m"), ("mNm", "mN m"), ("Nmm", "N mm"), ("lb-ft", "lbf ft"), ("ft-lb", "lbf ft")),
        *(("rad s⁻²", "rad/s^2"), ("m s-1", "m/s"), ("mm/sec", "mm/s"), ("N/mm2", "MPa")),
        *((text, None) for text in ("NM", "", "filtered", "N" * 41, "9" * 9, "m**9**9**9", "__import__('os')")),
    ],
)
def test_spellings_of_units(text, meant):
    named = unit_named(text)
    assert (named and named.name) == meant


def test_sizes_of_units():
    """By their definitions (NIST SP 811), to the last bit; and of prefixes, powers and quotients of them."""
    known = {"psi": 6894.757293168362, "kgf": 9.80665, "bar": 1e5, "mph": 0.44704, "turn": 2.0 * np.pi, "g": 9.80665}
    known |= {"mm": 0.001, "MN": 1e6, "um/s": 1e-6, "ms": 0.001, "ft/s^2": 0.3048, "deg": np.pi / 180.0, "%": 0.01}
    known |= {"dyn": 1e-5, "lbf/in2": 6894.757293168362, "kilonewtons": 1000.0, "m/(s^2)": 1.0, "Nm/rad": 1.0}
    assert {text: unit_named(text).factor for text in known} == known
    assert [unit_named(text).dimension for text in ("lb", "kHz", "mV", "Nm/rad")] == [
        "mass",
        "frequency",
        *["something else"] * 2,
    ]


@pytest.mark.parametrize(
    ("heading", "field", "factor"),
    [
        ("force [lbf]", "force", 4.4482216152605),  # 0.45359237 kg times 9.80665 m/s^2
        ("force [kip]", "force", 4448.2216152605),
        ("displacement [in]", "displacement", 0.0254),
        ("velocity [km/h]", "velocity", 1 / 3.6),
        ("time [h]", "time", 3600.0),
        ("time_min", "time", 60.0),
        ("angle [deg]", "displacement", np.pi / 180),
        ("velocity [rpm]", "velocity", np.pi / 30),
        ("torque [Nmm]", "force", 1e-3),
        ("torque [lbf in]", "force", 4.4482216152605 * 0.0254),
    ],
)
def test_units_of_the_heading_are_converted(written, heading, field, factor):
    """None of these was known before: they were read as SI without a word."""
    columns = {"time": "t", "force": "F", "velocity": "v", "displacement": "x"} | {field: heading}
    values = {"time": TIME, "force": FORCE, "velocity": VELOCITY, "displacement": DISPLACEMENT}
    table = {name: values[field] for field, name in columns.items()}
    table.pop("v" if field == "displacement" else columns["displacement"])
    (made,) = written(csv(table))
    np.testing.assert_allclose(getattr(made, field), factor * values[field], rtol=1e-14)
    turning = any(word in heading for word in ("deg", "rpm", "torque"))
    assert made.rotary == turning
    assert field not in made.guessed_units
    others = {"force": "N m" if turning else "N", "time": "s"}
    assert {k: v for k, v in made.guessed_units.items() if k in others} == {
        k: v for k, v in others.items() if k != field
    }


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"t": TIME, "force [foo]": FORCE, "v": VELOCITY}, "force: 'foo' is no unit that is known here"),
        ({"t": TIME, "force [kg]": FORCE, "v": VELOCITY}, "force: 'kg' is a unit of mass; should be N, kN"),
        ({"t": TIME, "F": FORCE, "velocity [mm]": VELOCITY}, "velocity: 'mm' is a unit of length; should be m/s"),
        ({"t": TIME, "F [kN]": FORCE, "angle [deg]": VELOCITY}, "should be a force over a straight motion"),
        ({"t": TIME, "mu": FORCE, "omega": VELOCITY}, "should be a force over a straight motion"),
        ({"t": TIME, "torque": FORCE, "x [mm]": VELOCITY}, "force (column 'torque') is in N m"),
    ],
)
def test_units_that_cannot_be_used_are_refused_by_name(written, columns, said):
    assert said in refused(written, csv(columns))


def test_a_unit_that_is_given_is_not_mistaken_for_one_that_looks_alike(written):
    """ "Nm" was read as a nanometre."""
    (made,) = written(csv({"t": TIME, "F": FORCE, "v": VELOCITY}), units={"force": "Nm"})
    np.testing.assert_array_equal(made.force, FORCE)
    assert made.rotary
    columns = {"torque": "F", "angular_velocity": "v", "angle": "x"}
    units = {"torque": "kNm", "angle": "deg"}
    (made,) = written(csv({**GOOD, "x": np.degrees(DISPLACEMENT)}), columns=columns, units=units)
    np.testing.assert_allclose(made.force, 1e3 * FORCE, rtol=1e-15)
    np.testing.assert_allclose(made.displacement, DISPLACEMENT, rtol=1e-14, atol=1e-300)
    assert made.rotary
    assert made.guessed_units == {"velocity": "rad/s", "time": "s"}
    assert "units: torque: 'kN' is a unit of force; should be N m" in refused(
        written, csv(GOOD), columns=columns, units={"torque": "kN"}
    )


def test_a_line_of_units_with_gaps_counts(written):
    (made,) = written(csv({**GOOD, "F": FORCE / 1e3, "note": TIME}, units=["s", "kN", "", "m", ""]))
    np.testing.assert_allclose(made.force, FORCE, rtol=1e-15)
    assert made.guessed_units == {"velocity": "m/s"}


# --- what is refused --------------------------------------------------------------------------------------------------


def test_every_wrong_setting_is_named_at_once(written):
    said = refused(
        written,
        csv(GOOD),
        columns={"forse": "F"},
        units={"force": "kg", "velocity": "mm", "displacment": "mm"},
        area=0,
        normal_force=float("nan"),
    )
    assert "columns: 'forse' is no quantity of a record; did you mean 'force'?" in said
    assert "units: 'displacment' is no quantity of a record; did you mean 'displacement'?" in said
    assert "units: force: 'kg' is a unit of mass; " in said
    assert "units: velocity: 'mm' is a unit of length; should be m/s, cm/s, mm/s, um/s, nm/s, km/h, " in said
    assert "area: should be a number greater than 0, got 0" in said
    assert "normal_force: should be a number greater than 0, got nan" in said


def test_settings_of_the_wrong_kind(written):
    assert "columns: should be a mapping such as {'force': 'F'}, got 'F'" in refused(written, csv(GOOD), columns="F")
    assert "dt: should be a number greater than 0, got 'fast'" in refused(written, csv(GOOD), dt="fast")
    assert "area: should be a number greater than 0, got True" in refused(written, csv(GOOD), area=True)


def test_columns_that_are_not_there(written):
    columns = {"t": TIME, "Load_cell_1": FORCE, "v": VELOCITY}
    said = refused(written, csv(columns), columns={"force": "load cell 2", "velocity": "V"})
    assert "columns: force:" in said
    assert "has no column 'load cell 2'; did you mean 'Load_cell_1'? there is 't', 'Load_cell_1', 'v'" in said
    assert "velocity" not in said  # capital letters aside, it is there
    said = refused(written, csv({"seconds": TIME, "load": FORCE, "rate": VELOCITY}))
    for quantity in ("time: no", "force: no", "velocity, displacement: no"):
        assert quantity in said
    assert "there is 'seconds', 'load', 'rate'" in said
    assert "units: displacement: is given, but there is no such column" in refused(
        written, csv({"t": TIME, "F": FORCE, "v": VELOCITY}), units={"displacement": "mm"}
    )


def test_a_bad_sample_is_named_by_its_line(written):
    lines = csv(GOOD, before="# made\n").splitlines()
    lines[6] = "nan,1,2,3"
    assert "time: 1 NaN of 12 values, the first at line 7" in refused(written, "\n".join(lines))
    lines = csv(GOOD, before="# made\n\n").splitlines()
    lines[7], lines[8] = lines[8], lines[7]
    assert "time: runs backwards at line 9: 0.4 after 0.5" in refused(written, "\n".join(lines))
    steady = csv({**GOOD, "F": np.full(N, 2.0)})
    assert "force: is 2 at all 12 samples; a constant force determines nothing" in refused(written, steady)
    assert "at least 8 samples, got 1 sample" in refused(written, "\n".join(csv(GOOD).splitlines()[:2]))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("\n \n", "is empty"),
        ("t,F,v\n", "there is no line of numbers"),
        ("# nothing\n", "there is no line of numbers"),
        (b"\x00\x01\x02\x03", "is not a text file"),
    ],
)
def test_files_without_data(written, text, said):
    assert said in refused(written, text)


def test_ragged_rows_and_text_in_numbers_are_named_by_line(written):
    lines = csv(GOOD).splitlines()
    lines[3] = "1,2,3"
    lines[5] = "1,2,3,4,5"
    said = refused(written, "\n".join(lines))
    assert "line 4: has 3 cells; should have 4" in said
    assert "line 6: has 5 cells; should have 4" in said
    lines = csv(GOOD).splitlines()
    lines[3] = "0.2,12a,3,4"
    lines[5] = "0.4,,3,1_0"
    said = refused(written, "\n".join(lines))
    assert "line 4, column 'F': '12a' is no number; should be one, nan or empty" in said
    assert "line 6, column 'F'" not in said  # an empty cell is a missing sample
    assert "line 6, column 'x': '1_0' is no number" in said
    lines = csv(GOOD).splitlines()
    lines[3], lines[4], lines[6] = "0.2,12a,3,4", "1,2,3", "1,2,3,4,5"  # both kinds at once, in the order of the file
    said = refused(written, "\n".join(lines))
    assert re.findall(r"line (\d)", said) == ["4", "5", "7"]
    lines = csv(GOOD).splitlines()
    said = refused(written, "\n".join(lines[:1] + [f"{at},a,2,3" for at in range(9)]))
    assert "and 4 more like these" in said


def with_columns(text, *columns):
    """A table with further columns: a heading, and what stands in each row."""
    lines = [line.split(",") for line in text.splitlines()]
    return "\n".join(",".join(cells + [c[0] if not at else c[1] for c in columns]) for at, cells in enumerate(lines))


def test_what_is_wrong_with_columns_that_are_not_used_counts_for_nothing(written):
    """Real files have words, empty cells and columns of one name beside the ones that are needed."""
    rest = (("status", "OK"), ("temp", "21.5"), ("temp", "22.5"), ("note", ""), ("temp", "x"), ("", ""))
    (made,) = written(with_columns(csv(GOOD), *rest))
    assert_good(made)
    lines = csv(GOOD).splitlines()
    lines[4:4] = [",,,", ""]  # a row without content
    (made,) = written("\n".join([*lines, ",,,", ","]))
    assert_good(made)


def test_columns_of_one_name_are_asked_for_by_their_places(written):
    """One that is needed is not guessed; what has the same cells twice, as the time of each channel, is one column."""
    twice = with_columns(csv(GOOD), ("F", "7"))
    said = refused(written, twice)
    assert "force: no column has a usual name" in said
    assert "there is 't', 'F #1', 'v', 'x', 'F #4'" in said
    assert "has no column 'F'; there is 't', 'F #1'" in refused(written, twice, columns={"force": "F"})
    for name in ("F #1", 1):
        assert_good(written(twice, columns={"force": name})[0])
    lines = [f"{line.split(',')[0]},{line}" for line in csv(GOOD).splitlines()]
    assert_good(written("\n".join(lines))[0])


@pytest.mark.parametrize("behind", ["", ",", ",,,"])
@pytest.mark.parametrize("pads", [True, False])
@pytest.mark.parametrize("names", [True, False])
def test_the_settings_of_an_instrument_before_the_table(written, behind, pads, names):
    """Names and numbers with the delimiters of the table, as spreadsheets write them, and rows that end in some."""
    settings = ["Model,XY-100", "Sample rate,1000", "Range,-5,5", "Channels,3,4", "", "1000", "Start,12:30:01"]
    padded = [line + "," * (3 - line.count(",")) + behind if pads and line else line for line in settings]
    header, *rows = csv(GOOD).splitlines()
    text = [*padded, header + behind, "s,N,m/s,m" + behind, *(row + behind for row in rows)]
    if not names:
        text = [*padded, *(row + behind for row in rows)]
    settings = {} if names else {"columns": {"time": 0, "force": 1, "velocity": 2, "displacement": 3}}
    assert_good(written("\n".join(text), **settings)[0])


def test_paths(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        read_records(tmp_path / "none.csv")
    assert "is a folder" in refused(read_records, tmp_path)
    assert "ends in '.docx'; should be .csv" in refused(read_records, tmp_path / "a.docx")


def test_a_unit_that_looks_wrong_is_warned_of(written):
    with pytest.warns(RecordWarning, match="displacement looks as if it were in mm"):
        written(csv({**GOOD, "x": 1e3 * DISPLACEMENT}))


@pytest.mark.parametrize(
    ("unit", "factor"), [("35.15 N", 35.15), ("-1 kN", -1e3), ("2e-3*MN", 2e3), ("0 N", None), ("3.5 apples", None)]
)
def test_a_unit_with_a_number_is_the_size_of_one_of_the_column(written, unit, factor):
    if factor is None:
        assert f"units: force: {unit!r} is no unit" in refused(written, csv(GOOD), units={"force": unit})
        return
    (made,) = written(csv(GOOD), units={"force": unit})
    np.testing.assert_allclose(made.force, factor * FORCE, rtol=1e-15)


# --- samples that are missing -----------------------------------------------------------------------------------------

LONG = {name: np.tile(values, 5) for name, values in GOOD.items()} | {"t": 0.1 * np.arange(5 * N)}


@pytest.mark.parametrize("mark", ["nan", "", "NaN"])
def test_a_record_ends_where_its_motion_is_unknown_and_another_begins_behind(written, mark):
    lines = csv(LONG).splitlines()
    for at in (1, 2, 30, 31, 36):  # the ends, the middle, and so near behind that nothing is left between
        t, _, v, x = lines[at].split(",")
        lines[at] = ",".join((t, mark, v, x))
    with pytest.warns(RecordWarning, match="9 of 60 samples are left out, the first at line 2; it continues as 2 rec"):
        made = written("\n".join(lines))
    assert [each.name for each in made] == ["data_part_1", "data_part_2"]
    for each, (first, last) in zip(made, ((2, 29), (36, 60)), strict=True):
        np.testing.assert_array_equal(each.time, LONG["t"][first:last])
        np.testing.assert_array_equal(each.force, LONG["F"][first:last])


@pytest.mark.parametrize(("skipped", "parts"), [(8, 1), (10, 2)])
def test_a_clock_that_skips_ten_samples_ends_a_record(written, skipped, parts):
    kept = np.r_[0:20, 19 + skipped : 60]
    with warnings.catch_warnings():
        warnings.simplefilter("error" if parts == 1 else "ignore")
        made = written(csv({name: values[kept] for name, values in LONG.items()}))
    assert [len(each) for each in made] == ([len(kept)] if parts == 1 else [20, len(kept) - 20])
    if parts == 2:  # what is left between two gaps is too short for a record
        kept = np.r_[0:20, 30:35, 46:60]
        with pytest.warns(RecordWarning, match="5 of 39 samples are left out, the first at line 22; no sample for 1"):
            made = written(csv({name: values[kept] for name, values in LONG.items()}))
        assert [len(each) for each in made] == [20, 14]
    uneven = {**LONG, "t": np.geomspace(1.0, 1e3, 60)}  # no clock
    assert len(written(csv(uneven))) == 1


def test_samples_that_are_missing_all_over_are_refused(written):
    holes = np.where(np.arange(40 * N) % 12 == 11, np.nan, np.tile(FORCE, 40))
    columns = {name: np.tile(values, 40) for name, values in GOOD.items()} | {"t": np.arange(40.0 * N), "F": holes}
    assert "force: 40 NaN of 480 values, the first at line 13" in refused(written, csv(columns))


# --- workbooks and JSON -----------------------------------------------------------------------------------------------


def test_a_workbook_is_read_as_a_text(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for name, factor in (("slow", 1.0), ("fast", 2.0)):
        sheet = book.create_sheet(name)
        for row in (["Rig", 7], [], ["Time [s]", "Force [kN]", "Velocity [mm/s]", "Note"]):
            sheet.append(row)
        for row in zip(TIME.tolist(), FORCE.tolist(), (factor * VELOCITY).tolist(), strict=True):
            sheet.append([*row, "ok"])
    book.save(tmp_path / "rig.xlsx")
    records = read_records(tmp_path / "rig.xlsx")
    assert [record.name for record in records] == ["slow", "fast"]
    book.create_sheet("words", 0).append(["Operator", "Smith"])
    about = book.create_sheet("about", 0)
    for row in (["mean", "largest"], *([value, value + 1.0] for value in range(4))):
        about.append(row)
    book.save(tmp_path / "told.xlsx")
    with pytest.warns(RecordWarning, match="'about' has no column of a record and is left out"):
        assert [record.name for record in read_records(tmp_path / "told.xlsx")] == ["slow", "fast"]
    np.testing.assert_allclose(records[1].velocity, 2e-3 * VELOCITY, rtol=1e-15)
    np.testing.assert_allclose(records[1].force, 1e3 * FORCE, rtol=1e-15)
    (tmp_path / "damaged.xlsx").write_bytes((tmp_path / "rig.xlsx").read_bytes()[:-200])
    assert "cannot be read as .xlsx" in refused(read_records, tmp_path / "damaged.xlsx")
    openpyxl.Workbook().save(tmp_path / "none.xlsx")
    assert "is empty" in refused(read_records, tmp_path / "none.xlsx")


SAMPLES = [dict(zip(GOOD, row, strict=True)) for row in zip(*(each.tolist() for each in GOOD.values()), strict=True)]
LISTS = {name: values.tolist() for name, values in GOOD.items()}


@pytest.mark.parametrize(
    ("content", "names"),
    [(LISTS, ["data"]), (SAMPLES, ["data"]), ({"a": LISTS, "b": {**LISTS, "mass_kg": 2}}, ["a", "b"])],
)
def test_json_holds_columns_records_or_samples(written, content, names):
    made = written(json.dumps(content), "data.json")
    assert [each.name for each in made] == names
    assert_good(made[-1])
    assert made[-1].conditions == ({"mass_kg": 2.0} if len(names) == 2 else {})


@pytest.mark.parametrize("text", ["{", "[1, 2]", "3", '{"t": "x"}', "[" * 100_000])
def test_json_without_columns_is_refused(written, text):
    assert "should be such as" in (said := refused(written, text, "data.json")) or "holds no columns of numbers" in said


# --- NPZ and MAT ------------------------------------------------------------------------------------------------------

RUNS = {f"run{at}_{name}": values for at in (1, 2) for name, values in GOOD.items()}
STRUCTURED = np.rec.fromarrays(list(GOOD.values()), names=list(GOOD))
MATRIX = np.column_stack([FORCE, DISPLACEMENT, VELOCITY])


@pytest.mark.parametrize(
    ("arrays", "names"),
    [
        (GOOD, ["data"]),
        (RUNS, ["run1", "run2"]),
        ({"t": TIME, **{name: values for name, values in RUNS.items() if not name.endswith("_t")}}, ["run1", "run2"]),
        ({"one": STRUCTURED, "two": STRUCTURED}, ["one", "two"]),
        ({"dt": 0.1, "columns": ["force_N", "disp_m", "vel_m_per_s"], "a": MATRIX, "b": MATRIX.T}, ["a", "b"]),
        ({"fs": 10.0, **{name: GOOD[name] for name in "Fvx"}}, ["data"]),
    ],
)
def test_layouts_of_numpy_files(tmp_path, arrays, names):
    path = tmp_path / "data.npz"
    np.savez(path, **arrays, mass_kg=2.0, operator="someone")
    records = read_records(path)
    assert [record.name for record in records] == names
    for entry in records:
        np.testing.assert_allclose(entry.time, TIME, rtol=1e-14, atol=1e-15)
        np.testing.assert_array_equal(entry.force, FORCE)
        np.testing.assert_array_equal(entry.velocity, VELOCITY)
        assert entry.conditions == {"mass_kg": 2.0}


def test_numpy_files_that_cannot_be_used(tmp_path):
    path = tmp_path / "data.npz"
    np.savez(path, t=np.array([1, None], dtype=object))
    assert "holds Python objects" in refused(read_records, path)
    path.write_text("no archive")
    assert "holds Python objects" in refused(read_records, path) or "cannot be read" in refused(read_records, path)
    np.savez(path, word="nothing")
    assert "holds no columns of numbers, only 'word'" in refused(read_records, path)
    np.savez(path, columns=["force", "x"], run=MATRIX)
    assert "run: has 3 columns, but 'columns' names 2: force, x" in refused(read_records, path)
    np.savez(path, t=TIME, F=FORCE[:-1], v=VELOCITY)
    assert "should have one value for each time, got time 12, force 11, velocity 12" in refused(read_records, path)
    assert "record: is for text files" in refused(read_records, path, columns={"record": "run"})
    np.savez(path, **{**RUNS, "run2_F": np.where(TIME > 0.5, np.nan, FORCE)})
    assert "record 'run2': force: 6 NaN of 12 values, the first at index 6" in refused(read_records, path)


def test_matlab_files_of_version_7_3(tmp_path, monkeypatch):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "data.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in GOOD.items():
            file[name] = values.reshape(1, -1)  # as MATLAB writes a column
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    assert_good(read_records(path)[0])
    monkeypatch.setitem(sys.modules, "h5py", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "is a .mat of version 7.3 (HDF5), which needs h5py" in refused(matlab.content_of, path)
