"""A record is checked when made and never changes."""

import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record
from dampyr.records.record import Label

T = 0.01 * np.arange(20)
X = np.sin(T)
F = np.cos(T)


def with_value(values, i, value):
    out = np.array(values)
    out[i] = value
    return out


def test_arrays_are_read_only_copies():
    x = X.copy()
    record = Record(T, x, F)
    x[0] = 99.0
    assert record.displacement[0] == X[0]
    with pytest.raises(ValueError, match="read-only"):
        record.displacement[0] = 1.0
    with pytest.raises(FrozenInstanceError):
        record.force = F
    with pytest.raises(TypeError):
        record.provenance["file"] = "x"


def test_properties():
    record = Record(T, X, F, current=np.linspace(0.0, 1.0, 20))
    assert (record.n, record.input, record.input_value) == (20, "A", pytest.approx(0.5))
    assert record.dt == pytest.approx(0.01)
    assert record.duration == pytest.approx(0.19)
    assert Record(T, X, F).input is None
    assert Record(T, X, F).input_value is None
    assert Record(T, X, F, voltage=1.98).voltage == 1.98


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"force": F[:-1]}, r"^force has 19 values and time has 20; give one value per sample$"),
        ({"voltage": F[:3]}, r"^voltage has 3 values and time has 20"),
        (
            {"displacement": with_value(X, 7, np.nan)},
            r"^displacement\[7\] = nan m is not finite \(1 such of 20\)",
        ),
        ({"temperature": with_value(X, 3, np.inf)}, r"^temperature\[3\] = inf degC is not finite"),
        ({"voltage": np.nan}, r"^voltage = nan V is not finite"),
        ({"time": with_value(T, 5, 0.01)}, r"^time\[5\] = 0.01 s does not come after 0.04 s; .*sort or cut"),
        ({"time": with_value(T, 5, 0.04)}, r"^time\[5\] = 0.04 s does not come after 0.04 s"),
        ({"voltage": 1.0, "current": 1.0}, r"^voltage and current are both given"),
        ({"role": "both"}, r"^role = 'both' is not known; choose 'fit' or 'validation'$"),
        ({"force": np.ones((20, 1))}, r"^force has the shape \(20, 1\); give one column of 20 values$"),
        ({"force": ["a"] * 20}, r"^force: 'a' is not a quantity; write a number and a unit, such as '12.4 mm'$"),
        ({"force": None}, r"^force is missing"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(changes, message):
    with pytest.raises(InputError, match=message) as caught:
        Record(**({"time": T, "displacement": X, "force": F} | changes))
    assert "\n" not in str(caught.value)


def test_too_few_samples():
    with pytest.raises(InputError, match=r"^the record has 7 samples; give at least 8$"):
        Record(T[:7], X[:7], F[:7])


@pytest.mark.parametrize("values", [(0.0, 1.0), (0.01, -1.0), (np.nan, 1.0)])
def test_label_is_checked(values):
    with pytest.raises(InputError, match="greater than 0"):
        Label(*values)


def test_replace_extends_the_history():
    first = Record(T, X, F, history=("read",))
    second = first.replace(note="doubled", force=2 * F)
    assert first.history == ("read",)
    assert second.history == ("read", "doubled")
    assert np.array_equal(second.force, 2 * F)
    with pytest.raises(InputError, match="has no field 'forces'"):
        first.replace(note="x", forces=F)


def test_records_travel_to_other_processes():
    record = Record(T, X, F, voltage=1.0, label=Label(0.02, 1.0, "4.2", 1), provenance={"file": "a"}, history=("b",))
    twin = pickle.loads(pickle.dumps(record))
    assert np.array_equal(twin.force, record.force)
    assert not twin.force.flags.writeable
    assert (twin.label, dict(twin.provenance), twin.history) == (record.label, {"file": "a"}, ("b",))
