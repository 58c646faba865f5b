"""The table of OUT: a row for each capture, by the outputs' names, in manifest.parquet."""
from __future__ import annotations

import io
import json
import os
from collections.abc import Iterable, Iterator
from typing import Any

from .._c import LOSSES
from ._errors import FleetError
from ._places import Place

NAME = "manifest.parquet"
ROWS = 10_000

COUNTS = ("records", "frames", "lines", "points", *LOSSES)


def schema() -> Any:
    import pyarrow as pa

    columns = [("output", pa.string()), ("source", pa.string()), ("size", pa.int64()), ("stamp", pa.string()),
               ("digest", pa.string()), ("options", pa.string()), ("version", pa.string()), ("status", pa.string()),
               ("message", pa.string()), ("output_size", pa.int64()), ("truncated", pa.bool_())]
    columns += [(name, pa.int64()) for name in (*COUNTS, "left_out")]
    return pa.schema([*columns, ("seconds", pa.float64())])


def read(out: Place) -> Iterator[dict[str, Any]]:
    """The rows of an earlier run, none if there was none."""
    if out.entry(NAME) is None:
        return
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        # Files and not paths: pyarrow refuses a path that is no text.
        with open(out.where(NAME), "rb") if out.is_local else io.BytesIO(out.read(NAME)) as file:
            for batch in pq.ParquetFile(file).iter_batches(batch_size=ROWS):
                yield from batch.select([c for c in schema().names if c in batch.schema.names]).to_pylist()
    except (pa.ArrowException, OSError) as error:
        raise FleetError(f"{out.where(NAME)}: cannot be read: {error}; remove it, and everything is converted again") from error


def write(out: Place, rows: Iterable[dict[str, Any]], folder: str, attempt: str) -> None:
    """Written whole in a folder of this machine, or of OUT if that is one, then named."""
    import pyarrow.parquet as pq

    path = out.where(attempt) if out.is_local else os.path.join(folder, NAME)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    form = schema()
    with open(path, "wb") as file:
        with pq.ParquetWriter(file, form, compression="zstd") as table:
            for batch in _batches(rows):
                table.write_table(_table(batch, form))
        file.flush()
        os.fsync(file.fileno())
    out.name_as(path, NAME, attempt)


def _table(rows: list[dict[str, Any]], form: Any) -> Any:
    """Rows as a table. pyarrow would ask pandas about a list, and to import that takes a third of a second."""
    from pyarrow import json as from_json

    lines = "\n".join(map(json.dumps, rows)).encode()
    return from_json.read_json(io.BytesIO(lines), from_json.ReadOptions(use_threads=False, block_size=len(lines)),
                               from_json.ParseOptions(explicit_schema=form, unexpected_field_behavior="ignore"))


def _batches(rows: Iterable[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    batch = []
    for row in rows:
        batch.append(row)
        if len(batch) == ROWS:
            yield batch
            batch = []
    if batch:
        yield batch
