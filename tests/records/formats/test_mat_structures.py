"""Structures in MATLAB files, version 5 as scipy writes it and 7.3 in the layout of MATLAB's HDF5, by dotted names."""

import struct

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from dampyr.errors import FileError
from dampyr.records import read

N = 60
T = 0.01 * np.arange(N)
X, F = 8.0 * np.sin(6 * T), 300.0 * np.cos(6 * T)
UNITS = {"time": "s", "displacement": "mm", "force": "N"}


def members(k=0):
    """A structure with two numbers and a text that are not channels."""
    return {"time": T, "disp": X + k, "force": F + k, "rate": 100.0, "gains": np.ones(3), "note": "warm"}


def of_version_5(path, **variables):
    savemat(path, variables, oned_as="column")
    return path


def of_version_7_3(path, **variables):
    """Groups for structures; fields of an array of structures, and cells, as references into #refs#; dimensions reversed."""
    with h5py.File(path, "w") as file:
        store = file.create_group("#refs#")

        def write(parent, name, value):
            if isinstance(value, dict):
                group = parent.create_group(name)
                group.attrs["MATLAB_class"] = np.bytes_("struct")
                for key, member in value.items():
                    write(group, key, member)
            elif isinstance(value, list):
                group = parent.create_group(name)
                group.attrs["MATLAB_class"] = np.bytes_("struct")
                for key in value[0]:
                    references = []
                    for member in value:
                        write(store, f"r{len(store)}", member[key])
                        references.append(store[f"r{len(store) - 1}"].ref)
                    group.create_dataset(key, data=np.array(references, dtype=h5py.ref_dtype)[:, None])
            elif isinstance(value, str):
                data = parent.create_dataset(name, data=np.frombuffer(value.encode("utf-16-le"), np.uint16)[:, None])
                data.attrs["MATLAB_class"] = np.bytes_("char")
            else:
                data = parent.create_dataset(name, data=np.atleast_2d(value))
                data.attrs["MATLAB_class"] = np.bytes_("double")

        for name, value in variables.items():
            write(file, name, value)
    return path


VERSIONS = pytest.mark.parametrize("write", [of_version_5, of_version_7_3])


def is_test(record, k=0):
    np.testing.assert_allclose(record.time, T, atol=1e-15)
    np.testing.assert_allclose(record.displacement, 1e-3 * (X + k), rtol=1e-14)
    np.testing.assert_allclose(record.force, F + k, rtol=1e-14)
    return True


@VERSIONS
def test_the_only_structure_is_the_table(tmp_path, write):
    record = read(write(tmp_path / "a.mat", test=members(), operator="X"), units=UNITS, no_input=True)
    assert is_test(record)
    assert "members of test" in record.history


@VERSIONS
def test_members_by_dotted_names_and_by_the_name_of_their_structure(tmp_path, write):
    path = write(tmp_path / "a.mat", rig={"run": members(), "idle": members(5)}, other=np.ones(4))
    columns = {"time": "rig.run.time", "displacement": "rig.idle.disp", "force": "rig.idle.force"}
    assert is_test(read(path, units=UNITS, columns=columns), 5)
    assert is_test(read(path, units=UNITS, variable="rig.run"))
    named = {"time": "time", "displacement": "disp", "force": "force"}
    assert is_test(read(path, units=UNITS, variable="rig.idle", columns=named), 5)
    with pytest.raises(FileError, match=r"holds the structures rig\.idle, rig\.run; name one, --variable rig\.idle"):
        read(path, units=UNITS)
    with pytest.raises(FileError, match=r"there is no variable 'rig\.run\.load'; choose from other, rig\.idle\.disp"):
        read(path, units=UNITS, columns=columns | {"force": "rig.run.load"})


@VERSIONS
def test_arrays_of_structures_count_from_0_and_as_matlab_from_1(tmp_path, write):
    path = write(tmp_path / "a.mat", tests=[members(), members(7)])
    assert is_test(read(path, units=UNITS, variable="tests[0]"))
    assert is_test(read(path, units=UNITS, variable="tests(2)"), 7)
    columns = {"time": "tests[0].time", "displacement": "tests(2).disp", "force": "tests[1].force"}
    assert is_test(read(path, units=UNITS, columns=columns), 7)


def test_cells_of_version_5(tmp_path):
    runs = np.empty(2, dtype=object)
    runs[:] = [members(), members(3)]
    assert is_test(read(of_version_5(tmp_path / "a.mat", runs=runs), units=UNITS, variable="runs[1]"), 3)


def opaque(path, name, kind):
    """A version 5 file with one object: an array of class 17, its name, MCOS, the object's class and what only MATLAB reads."""

    def element(code, data):
        return struct.pack("<II", code, len(data)) + data + b"\0" * (-len(data) % 8)

    texts = b"".join(element(1, text.encode()) for text in (name, "MCOS", kind))
    flags = element(6, struct.pack("<II", 13, 0))  # the class of uint32
    numbers = element(14, flags + element(5, struct.pack("<ii", 6, 1)) + element(1, b"") + element(6, bytes(24)))
    header = b"MATLAB 5.0 MAT-file".ljust(116) + bytes(8) + struct.pack("<HH", 0x0100, 0x4D49)
    path.write_bytes(header + element(14, element(6, struct.pack("<II", 17, 0)) + texts + numbers))
    return path


@pytest.mark.parametrize(
    ("kind", "repair"),
    [
        ("table", r"export it there: S = table2struct\(T, 'ToScalar', true\); save\('a\.mat', 'S'\)"),
        ("timetable", r"table2struct\(timetable2table\(T\), 'ToScalar', true\)"),
        ("timeseries", r"t = T\.Time; x = T\.Data"),
    ],
)
def test_objects_say_how_they_are_exported(tmp_path, kind, repair):
    path = tmp_path / "a.mat"
    opaque(path, "T", kind)
    with pytest.raises(FileError, match=f"the variable T is a MATLAB {kind}, which only MATLAB reads; .*{repair}"):
        read(path, units=UNITS)
    with pytest.raises(FileError, match=repair):
        read(path, units=UNITS, columns={"force": "T"}, dt=0.01)
    with h5py.File(path, "w") as file:
        file.create_dataset("T", data=np.zeros((1, 6), np.uint32)).attrs["MATLAB_class"] = np.bytes_(kind)
    with pytest.raises(FileError, match=repair):
        read(path, units=UNITS)


def test_a_struct_that_people_brought(first_day_cases):
    """Energy per cycle of 9.969 J by a closed form."""
    record = read(first_day_cases / "struct_v5.mat", units=UNITS)
    cycle = slice(400, 601)  # one of 1 Hz, at 5 ms
    work = np.trapezoid(record.force[cycle], record.displacement[cycle])
    assert work == pytest.approx(9.969, rel=5e-4)
