"""What a simulation gets wrong about a recording, and why."""

from __future__ import annotations

import html
import json
from typing import Any

from mgpi import _native
from mgpi.identifier import Progress
from mgpi.model import Model
from mgpi.recording import Recording


def diagnose(
    recording: Recording,
    *,
    model: Model | None = None,
    validate: Recording | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Diagnoses a recording.

    ``model``: an operator model to go on from. ``validate``: another recording of the same muscle that the
    gain is counted on, in the place of the last third of this one. ``progress(share, what)`` is called now
    and then; what it raises ends the work, and so does Ctrl-C.
    """
    native = None if model is None else model._native
    return Diagnosis(_native.diagnose(recording, native, validate, progress))


class Diagnosis:
    """A diagnosis: the verdict, the causes with what speaks for them, what does as well, and a model."""

    def __init__(self, native: _native.Diagnosed) -> None:
        self._native = native
        self.result: dict[str, Any] = json.loads(native.to_json())

    @property
    def verdict(self) -> str:
        """adequate, explained, confounded or unexplained."""
        return self.result["verdict"]

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        return self._native.sentence

    @property
    def model(self) -> Model:
        """The model, extended by the named causes where that is better."""
        return Model(self._native.model)

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row a cause: what is named, what fits best where nothing is, and what does as well."""
        named = [("named", cause) for cause in self.result["causes"]]
        best = [("best fit", cause) for cause in self.result["best_fit"]]
        rows = [
            {
                "cause": cause["name"],
                "role": role,
                "parameters": cause["parameters"],
                "share_of_residual": cause["share_of_residual"],
                "evidence": "; ".join(cause["evidence"]),
            }
            for role, cause in named + best
        ]
        for rivals in self.result["alternatives"]:
            words = "does as well as what is named" if rivals else "no cause at all does as well"
            rows.append(
                {
                    "cause": " + ".join(rivals) or "none",
                    "role": "rival",
                    "parameters": {},
                    "share_of_residual": None,
                    "evidence": words,
                }
            )
        return rows

    def to_frame(self) -> Any:
        """The rows as a pandas DataFrame."""
        import pandas as pd

        columns = ["cause", "role", "parameters", "share_of_residual", "evidence"]
        return pd.DataFrame(self.rows, columns=columns)

    def to_html(self) -> str:
        """The report as one page of HTML, as ``mgpi diagnose --report`` writes it."""
        return self._native.to_html()

    def plot(self, axes: Any = None) -> Any:
        """The error over time in the parts that ``mgpi diagnose`` judges, by matplotlib."""
        import matplotlib.pyplot as plt

        axes = plt.gca() if axes is None else axes
        shares = [(row["cause"], row["share_of_residual"]) for row in self.rows if row["share_of_residual"] is not None]
        axes.barh([cause for cause, _ in shares], [100.0 * share for _, share in shares])
        axes.set_xlabel("share of the squared error that goes with the cause (%)")
        axes.set_title(self.verdict)
        return axes

    def _repr_html_(self) -> str:
        """A table, for notebooks."""

        def cells(values: list[str], tag: str) -> str:
            return "".join(f"<{tag}>{html.escape(value)}</{tag}>" for value in values)

        def row(one: dict[str, Any]) -> list[str]:
            parameters = ", ".join(f"{key} {_short(value)}" for key, value in one["parameters"].items())
            share = one["share_of_residual"]
            return [
                one["cause"],
                one["role"],
                parameters,
                "" if share is None else f"{100.0 * share:.0f} %",
                one["evidence"],
            ]

        head = cells(["cause", "role", "parameters", "share of the error", "evidence"], "th")
        body = "".join(f"<tr>{cells(row(one), 'td')}</tr>" for one in self.rows)
        table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>" if self.rows else ""
        experiment = self.result["suggested_experiment"]
        ask = f"<p>To learn more: <code>{html.escape(experiment)}</code></p>" if experiment else ""
        verdict = f"<p><b>{html.escape(self.verdict)}</b>: {html.escape(self.sentence)}</p>"
        return verdict + table + ask

    def __repr__(self) -> str:
        return f"<mgpi.Diagnosis {self.verdict}: {self.sentence}>"


def _short(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_short(one) for one in value) + "]"
    return f"{value:.4g}"
