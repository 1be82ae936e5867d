"""Models: what a muscle does with an input, and the input that brings an output about."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgpi import _native
from mgpi.recording import Recording, floats


class Model:
    """A model of a muscle, from :class:`Identifier`, :func:`diagnose` or :meth:`load`."""

    def __init__(self, native: _native.Model) -> None:
        self._native = native

    @classmethod
    def load(cls, path: Any) -> Model:
        """Reads a model file."""
        return cls(_native.Model.load(path))

    @classmethod
    def from_toml(cls, text: str) -> Model:
        """Reads the text of a model file."""
        return cls(_native.Model.from_toml(text))

    def to_toml(self) -> str:
        """The text of its file."""
        return self._native.to_toml()

    def save(self, path: Any, *, overwrite: bool = False) -> None:
        """Writes its file, whole or not at all; an existing one only with ``overwrite``."""
        self._native.save(path, overwrite=overwrite)

    @property
    def kind(self) -> str:
        """mgpi, sgpi, agpi, cpi, mpi or egpi."""
        return self._native.kind

    @property
    def input_name(self) -> str:
        """The input, with its unit."""
        return self._native.input_name

    @property
    def output_name(self) -> str:
        """The output, with its unit."""
        return self._native.output_name

    @property
    def input_range(self) -> tuple[float, float]:
        """The inputs that it is valid for."""
        return self._native.input_range

    @property
    def output_range(self) -> tuple[float, float]:
        """The outputs at rest and, from there, at the highest input."""
        return self._native.output_range

    @property
    def extensions(self) -> list[str]:
        """The causes that it is extended by."""
        return self._native.extensions

    @property
    def parameters(self) -> dict[str, float]:
        """The raw parameters, by name with their unit."""
        return dict(self._native.parameters)

    @property
    def worth(self) -> str | None:
        """What it is worth, in a sentence."""
        return self._native.worth

    def simulate(
        self,
        input: Recording | ArrayLike,
        time_s: ArrayLike | None = None,
        *,
        load_n: ArrayLike | None = None,
        temperature_c: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """The output for every sample of a recording, or of an input, from rest.

        A model with extensions needs the times too, and the columns that they name.
        """
        if isinstance(input, Recording):
            return self._native.simulate_recording(input)
        arrays = [("time_s", time_s), ("load_n", load_n), ("temperature_c", temperature_c)]
        others = [None if values is None else floats(name, values) for name, values in arrays]
        return self._native.simulate_arrays(floats("input", input), *others)

    def inverse(
        self,
        wanted: ArrayLike,
        *,
        period_s: float | None = None,
        limits: tuple[float, float] | None = None,
        load_n: ArrayLike | None = None,
        temperature_c: ArrayLike | None = None,
    ) -> NDArray[np.float64]:
        """The input that brings the output to what is wanted, sample by sample from rest.

        A model with extensions needs the time between samples. The answer stays within ``limits``, by
        default the inputs that the model is valid for.
        """
        arrays = [("load_n", load_n), ("temperature_c", temperature_c)]
        others = [None if values is None else floats(name, values) for name, values in arrays]
        return self._native.inverse_arrays(floats("wanted", wanted), period_s, limits, *others)

    def __repr__(self) -> str:
        return repr(self._native)

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        return (Model.from_toml, (self.to_toml(),))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())
