"""Models in python-control: a muscle as a system in discrete time.

What a muscle without further effects remembers are the turning points of its input that later ones have not wiped
out. They are the state: as many numbers as turning points are kept, and how many there are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mgpi._native import ModelError
from mgpi.model import Model


def system(model: Model, *, dt: float | bool = True, name: str = "muscle", memory: int = 100) -> Any:
    """A model as a ``control.NonlinearIOSystem``, from input to output, at any period ``dt`` (s).

    It answers as :meth:`Model.simulate` does, but for roundings. ``memory`` is how many turning points it has room for. Models that are
    extended by other effects, whose answer depends on time, are refused.
    """
    import control

    if model.extensions:
        causes = ", ".join(model.extensions)
        raise ModelError(f"the model is extended by {causes}: its state is more than turning points")

    def update(_time: float, state: NDArray[np.float64], inputs: NDArray[np.float64], _parameters: Any) -> Any:
        kept = remembered(_turns(state), float(inputs[0]))
        if len(kept) > memory:
            raise ModelError(f"memory={memory}: the input has more turning points that are not wiped out")
        following = np.zeros(memory + 1)
        following[0], following[1 : len(kept) + 1] = len(kept), kept
        return following

    def output(_time: float, state: NDArray[np.float64], inputs: NDArray[np.float64], _parameters: Any) -> Any:
        return model.simulate([*_turns(state), float(inputs[0])])[-1:]

    states = ["turns", *(f"turn_{place + 1}" for place in range(memory))]
    return control.NonlinearIOSystem(
        update, output, inputs=[model.input_name], outputs=[model.output_name], states=states, dt=dt, name=name
    )


def _turns(state: NDArray[np.float64]) -> list[float]:
    return [float(turn) for turn in state[1 : int(state[0]) + 1]]


def remembered(turns: list[float], input: float) -> list[float]:
    """The turning points that count after a further input, which is the last of them.

    Two points between which the input has since swung at least as far both ways no longer count: it has come from
    beyond the second, and goes beyond the first.
    """
    kept = [*turns]
    # On the way in one direction only its end counts.
    if len(kept) > 1 and (kept[-1] - kept[-2]) * (input - kept[-1]) >= 0.0:
        kept.pop()
    elif kept and kept[-1] == input:
        kept.pop()
    while len(kept) > 2:
        before, first, second = kept[-3:]
        low, high = sorted((before, first))
        if not (low <= second <= high and (input - first) * (first - second) >= 0.0):
            break
        del kept[-2:]
    return [*kept, input]
