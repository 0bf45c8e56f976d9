"""Nominal inputs: noisy constants that agree are one input."""

from __future__ import annotations

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, nominal_inputs


def measured(value: float, noise: float = 0.005, n: int = 2000, seed: int = 0, **fields: object) -> Record:
    t = 0.002 * np.arange(n)
    values = value + noise * np.random.default_rng(seed).standard_normal(n)
    return Record(t, np.sin(t), np.cos(t), current=values, **fields)


def test_noisy_constants_that_agree_are_one_input() -> None:
    values = (-0.0141, 0.4996, 0.5003, 1.4991, 1.5027)
    records = [measured(value, seed=k) for k, value in enumerate(values)]
    nominal_records = nominal_inputs(records)
    assert [r.current for r in nominal_records] == [0.0, 0.5, 0.5, 1.501, 1.501]
    assert "constant but for noise, 0.4995 A as measured: counts as 0.5 A" in nominal_records[1].history[-1]
    assert all(isinstance(r.current, np.ndarray) for r in records)
    again = nominal_inputs(nominal_records)
    assert [r.current for r in again] == [r.current for r in nominal_records]


def test_inputs_that_differ_by_more_than_the_tolerance_stay_apart() -> None:
    nominal_records = nominal_inputs([measured(value, seed=k) for k, value in enumerate((1.0, 1.04, 1.5))])
    assert [r.current for r in nominal_records] == [1.0, 1.04, 1.5]
    chain = [measured(1.0 + 0.02 * k, noise=0.0, seed=k) for k in range(6)]
    assert len({r.input_value for r in nominal_inputs(chain)}) == 6


@pytest.mark.parametrize("shape", ["step", "ramp", "on and off", "wave"])
def test_an_input_that_varies_keeps_its_channel(shape: str) -> None:
    t = 0.002 * np.arange(2000)
    u = {
        "step": np.where(t < 3.0, 0.5, 0.6),
        "ramp": 0.5 + 0.03 * t,
        "on and off": 0.75 + 0.75 * np.sign(np.sin(60.0 * t)),
        "wave": 0.75 + 0.2 * np.sin(60.0 * t),
    }[shape]
    record = Record(t, np.sin(t), np.cos(t), current=u)
    [varying, constant] = nominal_inputs([record, measured(1.0)])
    assert varying is record
    assert constant.current == 1.0


def test_what_was_stated_stays_and_draws_what_was_measured() -> None:
    stated = [Record(*np.tile(np.arange(9.0), (3, 1)), current=value) for value in (0.0, 1.00, 1.01)]
    nominal_records = nominal_inputs([*stated, measured(0.997)])
    assert [r.current for r in nominal_records] == [0.0, 1.00, 1.01, 1.00]
    assert nominal_records[1] is stated[1]
    assert nominal_inputs([measured(1.497)], nominal_values=(0.0, 1.5))[0].current == 1.5


def test_volts_and_amperes_are_not_mixed() -> None:
    volts = Record(*np.tile(np.arange(9.0), (3, 1)), voltage=1.0, name="v")
    with pytest.raises(InputError, match="v has a voltage and record a current"):
        nominal_inputs([volts, measured(1.0)])
