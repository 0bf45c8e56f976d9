"""Universal files: dataset 58 in ASCII and binary after the layout of SDRC, and as pyuff writes it."""

import struct

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records import read

N = 100
T = 0.005 * np.arange(N)
X, F = 8.0 * np.sin(6 * T), 0.3 * np.cos(6 * T)
OPTIONS = {"voltage": 0.0}


def head(title, kind, label, unit, of_values, even, abscissa=17):
    """The eleven lines of text of a dataset 58, by the FORTRAN formats of the layout."""
    none = f" {'NONE':<20} {'NONE':<20}"
    return [
        f"{title:<80}", *["NONE"] * 4,
        f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{1:10d}{1:4d} {'NONE':<10}{1:10d}{1:4d}",
        f"{of_values:10d}{N:10d}{int(even):10d}{0.0:13.5E}{0.005 * even:13.5E}{0.0:13.5E}",
        f"{abscissa:10d}{0:5d}{0:5d}{0:5d} {'Time':<20} {'s':<20}",
        f"{kind:10d}{0:5d}{0:5d}{0:5d} {label:<20} {unit:<20}",
        *[f"{0:10d}{0:5d}{0:5d}{0:5d}{none}"] * 2,
    ]  # fmt: skip


def in_text(values, of_values, even):
    """6E13.5, 4E20.12, or pairs of E13.5 with E20.12."""
    if of_values == 2:
        words, k = [f"{v:13.5E}" for v in (values if even else np.column_stack([T, values]).ravel())], 6
    else:
        words, k = [f"{v:20.12E}" if even else f"{t:13.5E}{v:20.12E}" for t, v in zip(T, values)], 4 if even else 2
    return ["".join(words[j : j + k]) for j in range(0, len(words), k)]


USUAL = {"title": "load cell", "kind": 13, "label": "NONE", "unit": "kN"}
STROKE = {"values": X, "title": "LVDT", "kind": 8, "unit": "mm"}


def dataset(of_values=4, even=True, order="", mixed=False, values=F, **named):
    """A dataset 58 as bytes; with ``order`` it is 58b."""
    lines = head(*(named.get(name, usual) for name, usual in USUAL.items()), of_values, even, named.get("abscissa", 17))
    if not order:
        text = "\n".join(["    -1", "    58", *lines, *in_text(values, of_values, even), "    -1", ""])
        return text.replace("E+00", "D+00").encode()
    kind = "f" if of_values == 2 else "d"
    pairs = "f" + kind if mixed else 2 * kind
    body = b"".join(
        struct.pack(order + kind, v) if even else struct.pack(order + pairs, t, v) for t, v in zip(T, values)
    )
    mark = f"    58b{1 if order == '<' else 2:6d}{2:6d}{11:12d}{len(body):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    return "\r\n".join(["    -1", mark, *lines, ""]).encode() + body + b"\r\n    -1\r\n"


@pytest.mark.parametrize("of_values", [2, 4])
@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("order", ["", "<", ">"])
def test_displacement_and_force_by_their_types(tmp_path, of_values, even, order):
    path = tmp_path / "a.uff"
    mixed = not even and order == ">"
    how = {"of_values": of_values, "even": even, "order": order, "mixed": mixed}
    path.write_bytes(dataset(**how, **STROKE) + dataset(**how))
    record = read(path, **OPTIONS)
    digits = 1e-5 if not order and of_values == 2 else 1e-7 if of_values == 2 else 1e-12
    np.testing.assert_allclose(record.time, T, atol=1e-12 if even else 1e-6)
    np.testing.assert_allclose(record.displacement, 1e-3 * X, rtol=digits, atol=1e-9 * digits)
    np.testing.assert_allclose(record.force, 1e3 * F, rtol=digits, atol=1e-3 * digits)
    assert "channels by their types in the file: displacement, force" in record.history


def test_units_of_dataset_164_and_names_of_general_functions(tmp_path):
    system = f"{7:10d}{'Inch (pound f)':<20}{2:10d}"
    units = "\n".join(["    -1", "   164", system, "  3.937E+01  2.248E-01  1.8E+00", "    -1", ""])
    path = tmp_path / "a.unv"
    spectrum = dataset(title="Spectrum", kind=0, unit="NONE", abscissa=18)
    path.write_bytes(units.encode() + dataset(**STROKE | {"unit": "NONE"}) + spectrum + dataset(kind=0, title="Kraft"))
    record = read(path, **OPTIONS)
    np.testing.assert_allclose(record.displacement, 0.0254 * X, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(record.force, 1e3 * F, rtol=1e-11, atol=1e-9)
    assert "1 function of something else than time left out" in record.history
    path.write_bytes(dataset(**STROKE) + dataset(title="A") + dataset(title="B", values=2 * F))
    with pytest.raises(FileError, match=r"no column is the force \(there: time, LVDT, A, B\); declare which"):
        read(path, **OPTIONS)
    np.testing.assert_allclose(read(path, columns={"force": "B"}, **OPTIONS).force, 2e3 * F, rtol=1e-11, atol=1e-9)


def test_what_is_wrong_is_said_with_its_line(tmp_path):
    path, whole = tmp_path / "a.uff", dataset(**STROKE) + dataset()
    lines = whole.split(b"\n")
    second = next(k for k, line in enumerate(lines) if line.startswith(b"load cell"))
    number = lines[second + 11][:20]
    broken = {
        "has no end, -1; the file was cut": whole[:-10],
        f"line {second}: the header says 100 numbers and 96 follow": b"\n".join([*lines[:-4], *lines[-3:]]),
        f"line {second + 12}: .*abc.* is not a number": whole.replace(number, b"     abc            "),
        "has no dataset 58 that is a real function of time": b"    -1\n   151\nmodel\n    -1\n",
        "has no dataset 58 that is a real function of time but 1 function of something else": dataset(of_values=5),
        "values are not those of IEEE 754": dataset(order="<").replace(b"58b     1     2", b"58b     1     1"),
        "800 bytes should follow and .* do; it was cut": dataset(order="<")[:-100],
        "have different times": dataset(**STROKE) + dataset().replace(b"5.00000E-03", b"4.00000E-03"),
    }
    for words, content in broken.items():
        path.write_bytes(content)
        with pytest.raises(FileError, match=words):
            read(path, **OPTIONS)


@pytest.mark.by_hand
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # pyuff leaves its file open
@pytest.mark.parametrize("binary", [0, 1])
def test_files_of_pyuff(tmp_path, binary):
    pyuff = pytest.importorskip("pyuff", reason="pyuff, a writer of others, is not installed")
    file = pyuff.UFF(str(tmp_path / "a.uff"))
    for name, values, kind, unit in (("LVDT", X, 8, "mm"), ("load cell", F, 13, "kN")):
        stated = {"id1": name, "ordinate_spec_data_type": kind, "ordinate_axis_units_lab": unit, "binary": binary}
        stated |= {"type": 58, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "num_pts": N}
        stated |= {"abscissa_spacing": 1, "abscissa_min": 0, "abscissa_inc": 0.005, "abscissa_spec_data_type": 17}
        file.write_sets({"x": T, "data": values, "ord_data_type": 4, "orddenom_spec_data_type": 0, **stated}, "add")
    record = read(tmp_path / "a.uff", **OPTIONS)
    np.testing.assert_allclose(record.force, 1e3 * F, rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(record.displacement, 1e-3 * X, rtol=1e-11, atol=1e-13)
