"""Columns as CSV and Parquet."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ddh_twin_py.exchange.replay_columns import Column
from ddh_twin_py.rig.files import write_whole

_BLOCK = 4096  # rows that are formatted at once
_DIGITS, _DIGITS_OF_TIME = 7, 13  # significant ones; a sensor has 5


def write_csv(path: str | Path, columns: Sequence[Column], progress: Callable[[float], None] | None = None) -> Path:
    """Write columns as CSV (RFC 4180, UTF-8): first line `name [unit]`, numbers with a point, nothing where there is no value."""
    out = io.StringIO()
    out.write(",".join(column.heading for column in columns) + "\n")
    line = ",".join(map(_format, columns)) + "\n"
    count = columns[0].values.size if columns else 0
    for start in range(0, count, _BLOCK):
        block = [column.values[start : start + _BLOCK].tolist() for column in columns]
        out.write("".join([line % row for row in zip(*block, strict=True)]).replace("nan", ""))
        if progress is not None:
            progress(min(1.0, (start + _BLOCK) / count))
    return write_whole(path, out.getvalue())


def about_columns(columns: Sequence[Column]) -> list[dict[str, str]]:
    """Name, unit and meaning of each column, as plain data."""
    return [{"name": column.name, "unit": column.unit, "about": column.about} for column in columns]


def _format(column: Column) -> str:
    if column.values.dtype.kind == "i":
        return "%d"
    return f"%.{_DIGITS_OF_TIME if column.name == 'time' else _DIGITS}g"


def write_parquet(path: str | Path, columns: Sequence[Column], about: Mapping[str, object]) -> Path:
    """Write columns as Parquet: name as it is, unit and meaning in each field's metadata, `about` as JSON in the table's (key `ddh_twin`).

    A value that is not there is null.
    """
    import pyarrow
    import pyarrow.parquet

    arrays, fields = [], []
    for column in columns:
        missing = np.isnan(column.values) if column.values.dtype.kind == "f" else None
        array = pyarrow.array(column.values, mask=missing)
        arrays.append(array)
        fields.append(pyarrow.field(column.name, array.type, metadata={"unit": column.unit, "about": column.about}))
    schema = pyarrow.schema(fields, metadata={"ddh_twin": json.dumps(about, ensure_ascii=False)})
    content = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(arrays, schema=schema), content, compression="zstd")
    return write_whole(path, content.getvalue())
