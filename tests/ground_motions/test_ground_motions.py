import numpy as np
import pytest
from scipy.io import savemat

from dampyr import ground_motions
from dampyr.errors import FileError, InputError, MissingData
from dampyr.ground_motions import GroundMotion, el_centro, read

G = 9.80665
AT2 = (
    "PEER NGA STRONG MOTION DATABASE RECORD\nSomewhere, 1/1/2000\nACCELERATION "
    "TIME SERIES IN UNITS OF G\n{header}\n{values}\n"
)
VALUES = "  .1000000E-02  -.2000000E-02   .3000000E-02\n   .4000000E-02  -.5000000E-02\n"


def at2(folder, header="NPTS=   5, DT=   .0100 SEC,", values=VALUES):
    path = folder / "motion.AT2"
    path.write_text(AT2.format(header=header, values=values))
    return path


def text(folder, content, name="motion.txt"):
    path = folder / name
    path.write_text(content)
    return path


def test_el_centro_is_the_peknold_record_with_a_zero_in_front():
    motion = el_centro()
    assert motion.n == 1560
    assert motion.dt == 0.02
    assert motion.duration == pytest.approx(31.18)
    assert motion.pga == pytest.approx(0.31882 * G, rel=1e-12)
    assert motion.acceleration[:3] == pytest.approx([0.0, 0.0063 * G, 0.00364 * G], rel=1e-12)
    assert motion.acceleration[-1] == 0.0
    assert motion.time[-1] == pytest.approx(31.18)


def test_el_centro_agrees_with_the_file_of_the_data_folder(ground_motion_folder):
    lines = (ground_motion_folder / "el_centro_1940_ns_peknold.dat").read_text().splitlines()
    rows = [line for line in lines if line.strip() and not line.startswith("#")]
    words = [row[i : i + 10] for row in rows for i in range(0, len(row), 10)]
    values = np.array([float(word) for word in words if word.strip()])
    assert np.array_equal(el_centro().acceleration[1:], values[:1559] * G)


def test_the_mat_file_is_the_same_without_the_zero(ground_motion_folder):
    motion = read(ground_motion_folder / "ElCentroData.mat", units="g")
    assert motion.n == 1560
    assert motion.dt == 0.02
    assert motion.acceleration[:1559] == pytest.approx(el_centro().acceleration[1:], rel=1e-12, abs=1e-15)


def test_the_other_processing_is_read_as_it_stands(ground_motion_folder):
    motion = read(ground_motion_folder / "elcentro.dat", units="g")
    assert (motion.n, motion.dt) == (2688, 0.02)
    assert motion.pga == pytest.approx(0.348737 * G, rel=1e-5)


def test_scaled_keeps_the_original():
    motion = el_centro()
    twice = motion.scaled(2.0)
    assert twice.pga == pytest.approx(2 * motion.pga)
    assert motion.pga == pytest.approx(0.31882 * G)
    assert "x 2" in twice.name
    with pytest.raises(InputError, match="not a finite number"):
        motion.scaled(float("nan"))


def test_samples_are_read_only():
    with pytest.raises(ValueError, match="read-only"):
        el_centro().acceleration[0] = 1.0


@pytest.mark.parametrize(
    ("values", "dt", "message"),
    [
        ([0.0], 0.02, "at least 2 samples"),
        ([[0.0, 1.0]], 0.02, "one row"),
        ([0.0, np.nan, np.inf], 0.02, "2 of 3 samples are not finite, the first is number 2"),
        ([0.0, 1.0], 0.0, "dt = 0.0 s is not allowed"),
    ],
)
def test_bad_motions_are_refused(values, dt, message):
    with pytest.raises(InputError, match=message):
        GroundMotion(values, dt)


@pytest.mark.parametrize(
    "header",
    [
        "NPTS=   5, DT=   .0100 SEC,",
        "NPTS=  5, DT= 0.01 SEC",
        "    5    0.0100    NPTS, DT",
        "5 .0100 NPTS,DT",
    ],
)
def test_at2_in_both_styles(tmp_path, header):
    motion = read(at2(tmp_path, header))
    assert motion.dt == 0.01
    assert motion.acceleration == pytest.approx(np.array([1, -2, 3, 4, -5]) * 1e-3 * G)
    assert motion.name == "motion"
    assert "Somewhere" in motion.source


@pytest.mark.parametrize(
    ("header", "values", "arguments", "message"),
    [
        ("NPTS=   7, DT=   .0100 SEC,", VALUES, {}, r"NPTS = 7 but 5 values follow"),
        ("NPTS=   4, DT=   .0100 SEC,", VALUES, {}, r"NPTS = 4 but 5 values follow"),
        ("somewhere else", VALUES, {}, r"line 4 is 'somewhere else'; it must give NPTS and DT"),
        ("NPTS=   5, DT=   .0000 SEC,", VALUES, {}, r"DT > 0"),
        ("NPTS=   5, DT=   .0100 SEC,", VALUES.replace(".3", "x.3"), {}, r"line 5 is .* numbers only"),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES.replace("-.2000000E-02", "nan"),
            {},
            r"1 of 5 samples are not finite",
        ),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES,
            {"dt": 0.02},
            r"dt = 0.02 s contradicts the header's DT = 0.01 s",
        ),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES,
            {"units": "m/s^2"},
            r"units = 'm/s\^2' contradict the header's 'g'",
        ),
    ],
)
def test_an_at2_that_lies_is_refused_by_name(tmp_path, header, values, arguments, message):
    with pytest.raises(FileError, match=message) as caught:
        read(at2(tmp_path, header, values), **arguments)
    assert str(caught.value).startswith(str(tmp_path / "motion.AT2"))


def test_at2_cut_short(tmp_path):
    with pytest.raises(FileError, match="has 2 lines"):
        read(text(tmp_path, "PEER\nSomewhere\n", "cut.at2"))


def test_one_column_needs_its_step(tmp_path):
    path = text(tmp_path, "# a comment\n0.0\n0.1\n-0.2\n")
    assert read(path, units="g", dt=0.01).acceleration == pytest.approx(np.array([0.0, 0.1, -0.2]) * G)
    with pytest.raises(FileError, match="give the seconds between samples"):
        read(path, units="g")


@pytest.mark.parametrize("separator", [",", ";", "\t", "  ", ", "])
def test_two_columns_in_any_separation(tmp_path, separator):
    rows = "\n".join(f"{0.02 * k:.2f}{separator}{a}" for k, a in enumerate([0.0, 1.0, -2.0]))
    motion = read(text(tmp_path, rows, "motion.csv"), units="m/s^2")
    assert motion.dt == 0.02
    assert motion.acceleration.tolist() == [0.0, 1.0, -2.0]


def test_the_unit_may_stand_in_the_header(tmp_path):
    path = text(tmp_path, "time [s], acceleration [cm/s^2]\n0, 0\n0.02, 100\n", "motion.csv")
    assert read(path).acceleration.tolist() == pytest.approx([0.0, 1.0])
    with pytest.raises(FileError, match="contradict"):
        read(path, units="g")


@pytest.mark.parametrize(
    ("content", "arguments", "message"),
    [
        ("0 1\n0.02 2\n", {}, r"no unit is known .* units='g'"),
        ("0 1\n0.02 2\n", {"units": "parsec"}, r"parsec"),
        ("0 1\n0.02 x\n", {"units": "g"}, r"line 2 is '0.02 x'; it must hold 2 numbers"),
        ("0 1\n0.02\n", {"units": "g"}, r"line 2 is '0.02'"),
        ("0 1 2\n0 1 2\n", {"units": "g"}, r"holds 3 columns"),
        ("# nothing\n", {"units": "g"}, r"holds no numbers"),
        (
            "0 1\n0.02 2\n0.01 2\n",
            {"units": "g"},
            r"time does not increase from sample 2 \(0.02 s\) to 3 \(0.01 s\)",
        ),
        ("0 1\n0.02 2\n0.04 2\n0.09 2\n", {"units": "g"}, r"the step is 0.05 s after sample 3"),
        ("0 1\n0.02 nan\n", {"units": "g"}, r"1 of 2 samples are not finite"),
        ("nan 1\n0.02 1\n", {"units": "g"}, r"time is not finite at sample 1"),
        ("0 1\n", {"units": "g"}, r"1 sample"),
        ("0 1\n0.02 2\n", {"units": "g", "dt": 0.01}, r"contradicts its time column, 0.02 s"),
        ("t [ms],a [g]\n0,1\n20,2\n", {}, r"time is in ms"),
    ],
)
def test_bad_columns_are_refused_by_name(tmp_path, content, arguments, message):
    with pytest.raises(FileError, match=message) as caught:
        read(text(tmp_path, content), **arguments)
    assert str(caught.value).startswith(str(tmp_path / "motion.txt"))


def test_mat_files_without_a_table_are_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"x": np.zeros((5, 3))})
    with pytest.raises(FileError, match="holds x; it must hold one matrix"):
        read(tmp_path / "a.mat", units="g")
    savemat(tmp_path / "b.mat", {"x": np.column_stack([np.arange(5) * 0.02, np.ones(5)])})
    assert read(tmp_path / "b.mat", units="g").pga == pytest.approx(G)
    with pytest.raises(FileError, match="units='g'"):
        read(tmp_path / "b.mat")
    with pytest.raises(FileError, match="not a MATLAB file"):
        read(
            text(tmp_path, "no matlab at all, and long enough to be taken for a header" * 5, "c.mat"),
            units="g",
        )


def test_no_file_and_no_format(tmp_path):
    with pytest.raises(MissingData, match="no such file"):
        read(tmp_path / "nothing.at2")
    with pytest.raises(FileError, match=r"'.docx' is not a ground motion's; dampyr reads .*\.at2"):
        read(text(tmp_path, "", "motion.docx"))


def test_every_format_on_the_shelf_says_its_suffixes():
    formats = ground_motions.available_formats()
    assert {"at2", "columns", "mat"} <= set(formats)
    suffixes = [suffix for each in formats.values() for suffix in each]
    assert len(set(suffixes)) == len(suffixes)
