"""Tables from CSV files: a header, then a row of numbers per time."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from netdae.core.arrays import FloatArray
from netdae.core.errors import InputError
from netdae.core.files import no_file, reason_of, shown


def read_table(path: str | os.PathLike[str], *headers: Sequence[str]) -> dict[str, FloatArray]:
    """Columns of a CSV file by name, each (k,); the header must be one of `headers`, in this order.

    Blank lines do not count. Raises InputError that names the file, the line and the column.
    """
    source = Path(path)
    if trouble := no_file(source):
        raise InputError(f"{shown(source)}: {trouble}")
    try:
        with source.open(encoding="utf-8-sig", newline="") as stream:  # spreadsheets begin a file with a mark
            reader = csv.reader(stream)
            rows = [(reader.line_num, row) for row in reader if any(field.strip() for field in row)]
    except OSError as error:
        raise InputError(
            f"{source}: the table cannot be read: {reason_of(error)}: check its name and folder"
        ) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{source}: this is not a CSV table: {error}") from error
    expected = " or ".join(",".join(header) for header in headers)
    if not rows:
        raise InputError(f"{source}: the table is empty: give the header {expected} and a row per time")
    names = [name.strip() for name in rows[0][1]]
    if names not in [list(header) for header in headers]:
        raise InputError(f"{source}: the header is {','.join(names)!r}, expected {expected}")
    numbers = [_numbers_of(row, names, f"{source}: line {line}") for line, row in rows[1:]]
    columns = np.array(numbers, dtype=np.float64).reshape(-1, len(names)).T
    return dict(zip(names, columns, strict=True))


def _numbers_of(row: list[str], names: list[str], where: str) -> list[float]:
    if len(row) != len(names):
        raise InputError(f"{where} has {len(row)} fields, expected {len(names)}: {','.join(names)}")
    return [_number(field, name, where) for field, name in zip(row, names, strict=True)]


def _number(field: str, name: str, where: str) -> float:
    try:
        value = float(field)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {name} is {field.strip()!r}, expected a finite number")
    return value
