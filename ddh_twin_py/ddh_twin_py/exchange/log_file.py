"""One CSV log as columns of numbers; every error names file, line and column."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from decimal import Decimal
from pathlib import Path

import numpy as np

from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.mapping import ISO, Dialect, TimeRule, iso_to_ns
from ddh_twin_py.exchange.units import TIME_UNITS
from ddh_twin_py.rig.files import did_you_mean, no_regular_file

_DELIMITERS = ";\t,|"  # in order of preference where two are equally frequent
_LARGEST_NS = 2**63 - 1
_WIDEST = 60  # characters of a cell that are shown


@dataclass(frozen=True)
class LogFile:
    """A log, read: `headings`, and the cells of the columns that were asked for as texts; `lines[i]` is where row i stands.

    `dialect` names the delimiter that the file was cut at.
    """

    file: str
    headings: tuple[str, ...]
    lines: np.ndarray
    cells: dict[str, list[str]]
    dialect: Dialect

    def numbers(self, column: str) -> np.ndarray:
        """A column as float64[n], NaN where a cell says that there is nothing.

        Raises ExchangeError for a cell that is no number.
        """
        texts = self._pointed(column)
        grouped = any("_" in text for text in texts)  # 5_00 is a number of Python and of no log
        try:
            if not grouped:
                values = np.array(texts, dtype=np.float64)
                return np.where(np.isin(values, self.dialect.missing_values), np.nan, values)
        except ValueError:
            pass
        for i, text in enumerate(texts):
            try:
                float(text if "_" not in text else "no number")
            except ValueError:
                self.refuse(i, column, f"a number is needed{self._comma(text)}")
        raise AssertionError("no cell to blame")

    def stamps(self, rule: TimeRule) -> np.ndarray:
        """The column of time as int64[n], ns since 1970 UTC.

        Raises ExchangeError for a cell that is no time.
        """
        stamps = []
        for i, text in enumerate(self._pointed(rule.column)):
            try:
                if rule.unit == ISO:
                    stamp = iso_to_ns(datetime.fromisoformat(text))
                else:
                    stamp = int((Decimal(text) * TIME_UNITS[rule.unit]).to_integral_value()) + rule.since_ns
            except (ValueError, ArithmeticError):
                self.refuse(i, rule.column, f"a time in {rule.unit} is needed{self._comma(text)}")
            if not 0 <= stamp <= _LARGEST_NS:
                self.refuse(i, rule.column, "with time.unit and time.since it lies before 1970 or after 2262")
            stamps.append(stamp)
        return np.array(stamps, np.int64)

    def refuse(self, row: int, column: str, why: str) -> None:
        """Raise what is said of one cell."""
        text, line = self.cells[column][row].strip(), self.lines[row]
        shown = text if len(text) <= _WIDEST else text[:_WIDEST] + "..."
        raise ExchangeError(f"{self.file}: line {line}, column {column!r}: value is {shown!r}; {why}")

    def _comma(self, text: str) -> str:
        return "; decimals with a comma: csv.decimal: ','" if "," in text and self.dialect.decimal == "." else ""

    def _pointed(self, column: str) -> list[str]:
        missing = set(self.dialect.missing)
        texts = [text.strip() for text in self.cells[column]]
        pointed = [text.replace(",", ".") for text in texts] if self.dialect.decimal == "," else texts
        return ["nan" if text in missing or told in missing else told for text, told in zip(texts, pointed, strict=True)]


def read_log(path: str | Path, dialect: Dialect, wanted: Sequence[str]) -> LogFile:
    """Read those of the wanted columns that a log has.

    Raises:
        ExchangeError: no such file, not text of that encoding, no heading, two columns of one name, or a line with too few cells.
    """
    file = str(path)
    headings: tuple[str, ...] = ()
    places: dict[str, int] = {}
    cells: dict[str, list[str]] = {}
    lines: list[int] = []
    try:
        if (what := no_regular_file(path)) not in ("", "a folder"):
            raise ExchangeError(f"{file}: is {what}, a regular file is needed")
        with open(path, encoding=dialect.encoding, newline="") as stream:
            dialect = replace(dialect, delimiter=dialect.delimiter or _delimiter(stream, dialect))
            stream.seek(0)
            reader = csv.reader(stream, delimiter=dialect.delimiter)
            for row in reader:
                line = reader.line_num
                if line < dialect.header_line or not row or dialect.comment and row[0].startswith(dialect.comment):
                    continue
                if not headings:
                    headings = tuple(cell.strip() for cell in row)
                    places = _places(file, headings, wanted, dialect)
                    cells = {name: [] for name in places}
                elif line >= dialect.data_line and any(row):
                    if len(row) <= max(places.values(), default=-1):
                        raise ExchangeError(f"{file}: line {line}: has {len(row)} of the {len(headings)} cells of the heading")
                    if dialect.delimiter == dialect.decimal and len(row) != len(headings):
                        raise ExchangeError(f"{file}: line {line}: has {len(row)} cells and the heading {len(headings)}; where the comma "
                                            "is csv.delimiter and csv.decimal, a number with a comma stands in quotes")
                    lines.append(line)
                    for name, at in places.items():
                        cells[name].append(row[at])
    except FileNotFoundError:
        raise ExchangeError(f"{file}: no such file{did_you_mean(file)}") from None
    except UnicodeError as error:
        raise ExchangeError(f"{file}: is not text in {dialect.encoding} ({' '.join(str(error).split())}); say the right one with "
                            "csv.encoding in the mapping, often latin-1 or utf-16") from None
    except csv.Error as error:
        raise ExchangeError(f"{file}: line {reader.line_num}: {error}") from None
    except OSError as error:
        raise ExchangeError(f"{file}: cannot be read: {error.strerror}") from None
    if not headings:
        raise ExchangeError(f"{file}: has no line {dialect.header_line}, where the names of the columns are (csv.header_line)")
    return LogFile(file, headings, np.array(lines, np.int64), cells, dialect)


def _places(file: str, headings: Sequence[str], wanted: Sequence[str], dialect: Dialect) -> dict[str, int]:
    """Where those of the wanted columns stand that there are. Raises ExchangeError where two have one name."""
    places = {}
    for name in dict.fromkeys(wanted):
        if headings.count(name) > 1:
            raise ExchangeError(f"{file}: line {dialect.header_line}: {headings.count(name)} columns are named {name!r}")
        if name in headings:
            places[name] = headings.index(name)
    return places


def headings_of(path: str | Path, dialect: Dialect) -> tuple[str, ...]:
    """The names of a log's columns. Raises ExchangeError as `read_log` does."""
    return read_log(path, dialect, ()).headings


def _delimiter(stream, dialect: Dialect) -> str:
    """What the heading is most cut by; by the decimal comma only where nothing else is there."""
    for number, line in enumerate(stream, 1):
        if number >= dialect.header_line and line.strip() and not (dialect.comment and line.startswith(dialect.comment)):
            return max(_DELIMITERS, key=lambda mark: (mark != dialect.decimal and mark in line, line.count(mark)))
    return ","
