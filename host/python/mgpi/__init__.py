"""Hysteresis of pneumatic muscles: identification, diagnosis and simulation.

    import mgpi

    recording = mgpi.Recording("recording.csv")
    identifier = mgpi.Identifier(plays=10, dead_zones=10).fit(recording)
    simulated = identifier.predict(recording)
    identifier.model_.save("model.toml")
    mgpi.diagnose(recording)  # in a notebook: a table of causes

Results are those of the command ``mgpi``, bit for bit.
"""

from mgpi._native import VERSION as __version__
from mgpi._native import DataError, DiagnosisError, IdentificationError, ModelError
from mgpi.diagnosis import Diagnosis, diagnose
from mgpi.identifier import Identifier
from mgpi.model import Model
from mgpi.recording import Recording

# An error that has no place has none; the compiled part says those that have one.
for _name in ("file", "line", "row", "column"):
    setattr(DataError, _name, None)

__all__ = [
    "DataError",
    "Diagnosis",
    "DiagnosisError",
    "IdentificationError",
    "Identifier",
    "Model",
    "ModelError",
    "Recording",
    "__version__",
    "diagnose",
]
