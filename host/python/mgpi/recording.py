"""Recordings: from a file, from arrays, from pandas."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgpi import _native


class Recording(_native.Recording):
    """A recording of a muscle: times, an input, an output.

    ``data`` is

    * the path of a file: a table as loggers write them, read as the command ``mgpi`` does;
    * a mapping from column names to arrays, ``{"time_s": t, "pressure_bar": p, "contraction_mm": x}``;
    * a pandas DataFrame; its index is a column if it has a name, or is one of times.

    Names end in their units. The input is ``pressure_bar``, else ``command_bar``, the output
    ``contraction_mm``, unless ``input`` and ``output`` name others. ``columns={"pressure": "p:psi"}`` gives
    columns of other names ours, with their unit, ``units={"time": "ms"}`` units to columns that have none.
    A value that is missing is NaN. ``load_n``, ``temperature_c``, ``command_bar`` beside ``pressure_bar``
    and ``valid`` (0: history only, not scored) are used where they are there.

    ``rest_length_mm`` turns ``length_mm`` into a contraction; a value outside ``input_range`` is refused;
    ``strict`` refuses what would have to be mended; ``name`` is that of arrays in messages.

    Raises ``DataError``, which knows ``row`` (of arrays, from 0), ``line`` (of a file, from 1) and ``column``.
    """

    def __new__(
        cls,
        data: str | os.PathLike[str] | Mapping[str, ArrayLike] | Any,
        *,
        input: str | None = None,
        output: str | None = None,
        rest_length_mm: float | None = None,
        input_range: tuple[float, float] | None = None,
        time: str | None = None,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        strict: bool = False,
        name: str = "arrays",
    ) -> Recording:
        is_file = isinstance(data, (str, os.PathLike))
        return super().__new__(
            cls,
            os.fspath(data) if is_file else name,
            None if is_file else _columns(data),
            input=input,
            output=output,
            rest_length_mm=rest_length_mm,
            input_range=input_range,
            time=time,
            renamed=[f"{ours}={theirs}" for ours, theirs in (columns or {}).items()],
            units=[f"{column}={unit}" for column, unit in (units or {}).items()],
            strict=strict,
        )

    @property
    def left_out(self) -> dict[str, Any]:
        """Which samples are not scored, and why."""
        return json.loads(self.left_out_json())

    def figures(self, simulated: ArrayLike) -> dict[str, float]:
        """RMSE, mean and largest absolute error of an answer over the scored samples."""
        return json.loads(self.figures_json(floats("simulated", simulated)))

    def to_frame(self) -> Any:
        """A pandas DataFrame of input, output and scored over the times."""
        import pandas as pd

        values = {self.input_name: self.input, self.output_name: self.output, "scored": self.scored}
        return pd.DataFrame(values, index=pd.Index(self.time_s, name="time_s"))

    def __repr__(self) -> str:
        ends_s = self.time_s[-1]
        return (
            f"<mgpi.Recording {self.file}: {self.input_name} to {self.output_name}, "
            f"{len(self)} samples over {ends_s:.1f} s, stroke {self.stroke:.4g} {self.output_unit}>"
        )


def floats(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """One row of numbers; what is no number, or no row, is refused by its name."""
    array = np.asarray(values)
    if array.ndim == 2 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim != 1:
        raise _native.DataError(f"{name}: one value a sample is needed, not an array of shape {array.shape}")
    if array.dtype.kind == "M":
        return _seconds(name, array)
    if array.dtype.kind not in "fiub":
        array = _of_objects(name, array)
    return np.ascontiguousarray(array, dtype=np.float64)


def _seconds(name: str, stamps: NDArray[Any]) -> NDArray[np.float64]:
    """Dates and times of day as seconds since the first."""
    missing = np.flatnonzero(np.isnat(stamps))
    if missing.size:
        error = _native.DataError(f"row {missing[0]}, column {name}: no time")
        error.row, error.column = int(missing[0]), name
        raise error
    return (stamps - stamps[0]) / np.timedelta64(1, "s") if stamps.size else np.empty(0)


def _of_objects(name: str, values: NDArray[Any]) -> NDArray[np.float64]:
    """Numbers out of Python's objects; None is a missing one."""
    numbers = np.empty(len(values))
    for row, value in enumerate(values.tolist()):
        try:
            numbers[row] = np.nan if value is None else float(value)
        except (TypeError, ValueError):
            error = _native.DataError(f"row {row}, column {name}: `{value}` is not a number")
            error.row, error.column = row, name
            raise error from None
    return numbers


def _columns(data: Any) -> list[tuple[str, NDArray[np.float64]]]:
    """Names and values, in order. Columns of text that nobody asks for are left out, as in a file."""
    named: Iterable[tuple[str, Any]]
    if isinstance(data, np.ndarray) and data.dtype.names:
        named = [(name, data[name]) for name in data.dtype.names]
    elif hasattr(data, "to_numpy") and hasattr(data, "columns"):
        named = [(str(name), data[name].to_numpy()) for name in data.columns]
        index = data.index
        if index.name is not None or index.dtype.kind == "M":
            stamped = index.dtype.kind == "M"
            name = "time_s" if stamped else str(index.name)
            named = [(name, index.to_numpy()), *named]
    elif isinstance(data, Mapping):
        named = [(str(name), values) for name, values in data.items()]
    else:
        kind = type(data).__name__
        raise TypeError(f"a path, a mapping from names to arrays or a DataFrame is needed, not {kind}")
    found = []
    for name, values in named:
        stamped = np.asarray(values).dtype.kind == "M" and not name.endswith("_s")
        found.append((f"{name}_s" if stamped else name, floats(name, values)))
    return found
