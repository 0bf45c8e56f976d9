"""A result as JSON and as a data frame."""

from __future__ import annotations

import dataclasses
from typing import Any

from dampyr.data_frames import data_frame
from dampyr.errors import InputError
from dampyr.show.descriptions import description_of


def as_dict(result: Any) -> dict[str, Any]:
    """What JSON holds of a result: what its description says, else its fields."""
    description = description_of(result)
    if description.data is not None:
        return dict(description.data())
    if not dataclasses.is_dataclass(result):
        raise InputError(f"{type(result).__name__} is not data that JSON holds")
    return {field.name: getattr(result, field.name) for field in dataclasses.fields(result)}


def as_frame(result: Any) -> Any:
    """A ``pandas.DataFrame`` of a result: what its description says, else its first table."""
    description = description_of(result)
    if description.frame is not None:
        frame = description.frame()
        return data_frame(frame.columns, frame.index, frame.index_name)
    if not description.tables:
        raise InputError(f"{type(result).__name__} is not a table, so it makes no data frame")
    table = description.tables[0]()
    return data_frame({head: [row[k] for row in table.rows] for k, head in enumerate(table.heads)})
