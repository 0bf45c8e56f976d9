"""Data frames of results, and the names of their columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dampyr.errors import InputError


def data_frame(columns: Mapping[str, Any], index: Sequence[Any] | None = None, index_name: str = "") -> Any:
    """A ``pandas.DataFrame`` of these columns; :class:`~dampyr.errors.InputError` where pandas is not installed."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise InputError(
            "a data frame needs pandas, which is not installed; install it with: python -m pip install pandas"
        ) from None
    frame = DataFrame(dict(columns), index=None if index is None else list(index))
    return frame.rename_axis(index_name) if index_name else frame


def column_name(quantity: str, unit: str) -> str:
    """The name of a column in SI units, such as ``velocity_m_per_s``."""
    spelled = unit.replace("^", "").replace("/", "_per_").replace(" ", "_").removeprefix("1_per_")
    if unit.startswith("1/"):
        spelled = f"per_{spelled}"
    return f"{quantity}_{spelled}" if unit else quantity
