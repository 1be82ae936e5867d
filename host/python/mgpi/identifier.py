"""Identification in the manner of scikit-learn, which is not needed for it."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mgpi import _native
from mgpi.model import Model
from mgpi.recording import Recording, floats

Progress = Callable[[float, str], None]


class Identifier:
    """Identifies a model of a muscle.

    ``model``: mgpi, sgpi, agpi, cpi, mpi or egpi. ``weights``: of the plays, ``"exponential"`` or ``"free"``.
    ``knots``: of a piecewise-linear envelope, for mgpi and sgpi; None for tanh. ``loss``: ``"squares"``, or
    ``"huber"`` where outliers are to count less. ``starts`` and ``seed``: of the search. ``threads``: 0 for
    one a core; the answer does not depend on it. ``holdout``: try the model on what it has not seen, too.

    After :meth:`fit`: ``model_`` (:class:`Model`), ``result_`` (what ``mgpi identify --json`` writes),
    ``parameters_`` (a data frame where pandas is installed, else a list), ``training_``, ``heldout_``.
    """

    def __init__(
        self,
        model: str = "mgpi",
        plays: int = 10,
        dead_zones: int = 10,
        *,
        weights: str = "exponential",
        knots: int | None = None,
        loss: str = "squares",
        starts: int = 24,
        seed: int = 1,
        threads: int = 0,
        holdout: bool = False,
    ) -> None:
        self.model = model
        self.plays = plays
        self.dead_zones = dead_zones
        self.weights = weights
        self.knots = knots
        self.loss = loss
        self.starts = starts
        self.seed = seed
        self.threads = threads
        self.holdout = holdout

    def fit(
        self,
        X: Recording | Sequence[Recording] | ArrayLike,
        y: ArrayLike | None = None,
        *,
        validate: Recording | None = None,
        progress: Progress | None = None,
    ) -> Identifier:
        """Identifies from a recording, from several of one muscle, or from an input and an output.

        Each recording begins from rest. Of a bare input and output the samples are taken to be equally far
        apart. ``validate`` is another recording that the model is tried on. ``progress(share, what)`` is
        called now and then; what it raises ends the work, and so does Ctrl-C.
        """
        recordings = _recordings(X, y)
        self.fit_ = _native.identify(
            recordings,
            validate,
            model=self.model,
            plays=self.plays,
            dead_zones=self.dead_zones,
            weights=self.weights,
            knots=self.knots,
            loss=self.loss,
            starts=self.starts,
            seed=self.seed,
            threads=self.threads,
            holdout=self.holdout,
            progress=progress,
        )
        self.model_ = Model(self.fit_.model)
        self.result_: dict[str, Any] = json.loads(self.fit_.to_json())
        self.training_: dict[str, float] = self.result_["training"]
        self.heldout_: dict[str, float] | None = self.result_["heldout"]
        self.n_features_in_ = 1
        return self

    @property
    def parameters_(self) -> Any:
        """The parameters with their standard errors, intervals and units."""
        rows = self._fitted().result_["parameters"]
        try:
            import pandas as pd
        except ImportError:
            return rows
        return pd.DataFrame(rows).set_index("name")

    def predict(self, X: Recording | ArrayLike) -> NDArray[np.float64]:
        """What the model answers to a recording's input, or to an input, from rest."""
        model = self._fitted().model_
        return model.simulate(X if isinstance(X, Recording) else _feature(X))

    def score(self, X: Recording | ArrayLike, y: ArrayLike | None = None) -> float:
        """R², the share of the output's variance that the model explains, over the scored samples."""
        if isinstance(X, Recording):
            measured, scored = X.output, X.scored
        else:
            measured = _target(y)
            scored = np.ones(len(measured), dtype=bool)
        answered = self.predict(X)
        left = np.sum((measured - answered)[scored] ** 2)
        return float(1.0 - left / np.sum((measured[scored] - measured[scored].mean()) ** 2))

    def report(self) -> str:
        """The report as one page of HTML."""
        return self._fitted().fit_.to_html()

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters of the constructor."""
        return {name: getattr(self, name) for name in _NAMES}

    def set_params(self, **params: Any) -> Identifier:
        """Sets parameters of the constructor."""
        for name, value in params.items():
            if name not in _NAMES:
                raise ValueError(f"{name} is no parameter of an Identifier; known are {', '.join(_NAMES)}")
            setattr(self, name, value)
        return self

    def _fitted(self) -> Identifier:
        if not hasattr(self, "model_"):
            raise _not_fitted()
        return self

    def __repr__(self) -> str:
        defaults = inspect.signature(Identifier).parameters
        said = [f"{name}={value!r}" for name, value in self.get_params().items() if value != defaults[name].default]
        return f"Identifier({', '.join(said)})"

    def __getstate__(self) -> dict[str, Any]:
        # The native result is not kept: what is pickled is what predicts.
        return {name: value for name, value in self.__dict__.items() if name != "fit_"}

    def __sklearn_tags__(self) -> Any:
        from sklearn.utils import InputTags, RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True, single_output=True),
            input_tags=InputTags(one_d_array=False, two_d_array=True),
            # Order matters: what a muscle does depends on what it has been through.
            regressor_tags=RegressorTags(poor_score=True),
            non_deterministic=False,
        )


_NAMES = tuple(inspect.signature(Identifier).parameters)


def _recordings(X: Any, y: Any) -> list[Recording]:
    if isinstance(X, Recording):
        return [X]
    if isinstance(X, Sequence) and X and all(isinstance(one, Recording) for one in X):
        return list(X)
    input, output = _feature(X), _target(y)
    if len(input) != len(output):
        raise _native.DataError(f"X has {len(input)} samples, y has {len(output)}")
    if len(input) < 2:
        raise ValueError(f"{len(input)} sample: a course of the input is needed")
    # A second for a thousand samples; no model of the family depends on it.
    arrays = {"time_s": np.arange(len(input)) / 1000.0, "input_n": input, "output_n": output}
    return [Recording(arrays, input="input_n", output="output_n", name="X and y")]


def _feature(X: Any) -> NDArray[np.float64]:
    if hasattr(X, "toarray"):
        raise TypeError("X is sparse; sparse data is not supported, only arrays that hold every sample")
    array = np.asarray(X)
    if array.ndim == 2 and array.shape[1] != 1:
        raise ValueError(f"X has {array.shape[1]} features; a muscle has one input, so one is needed")
    return _finite("X", array)


def _target(y: Any) -> NDArray[np.float64]:
    if y is None:
        raise ValueError("requires y to be passed, but the target y is None")
    return _finite("y", np.asarray(y))


def _finite(name: str, array: NDArray[Any]) -> NDArray[np.float64]:
    """Arrays without names have no holes: what comes out has a value for every one that goes in."""
    if array.dtype.kind == "c":
        raise ValueError(f"Complex data not supported: {name} is complex")
    values = floats(name, array)
    missing = np.flatnonzero(~np.isfinite(values))
    if missing.size:
        raise ValueError(f"{name} contains NaN or infinity, the first in row {missing[0]}")
    return values


def _not_fitted() -> Exception:
    words = "This Identifier is not fitted yet: call fit first"
    try:
        from sklearn.exceptions import NotFittedError
    except ImportError:
        return AttributeError(words)
    return NotFittedError(words)
