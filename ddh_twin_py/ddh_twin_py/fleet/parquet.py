"""A fleet's table as Parquet."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from ddh_twin_py.fleet.row import COLUMNS, NUMBERS, Row
from ddh_twin_py.rig.files import write_whole


def write_parquet(path: str | Path, rows: Sequence[Row]) -> None:
    """Write the table, whole or not at all; numbers are float64, `begin` is a time in UTC, all else text."""
    import pyarrow
    import pyarrow.parquet

    columns = {name: [_as_utf8(asdict(row)[name]) for row in rows] for name in COLUMNS}
    columns["begin"] = [row.time for row in rows]
    types = {name: pyarrow.float64() if name in NUMBERS else pyarrow.string() for name in COLUMNS}
    types["begin"] = pyarrow.timestamp("s", tz="UTC")
    table = pyarrow.table({name: pyarrow.array(columns[name], types[name]) for name in COLUMNS})
    content = io.BytesIO()
    pyarrow.parquet.write_table(table, content)
    write_whole(path, content.getvalue())


def _as_utf8(value: str | float | None) -> str | float | None:
    return value.encode("utf-8", "backslashreplace").decode() if isinstance(value, str) else value
