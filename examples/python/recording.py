"""Reads what mgpi reads and writes: a recording, a model, a log.

    python3 recording.py recording.csv model.toml log.csv
"""
import sys
import tomllib

import pandas as pd

recording_file, model_file, log_file = sys.argv[1:4]

# A recording in one line; the columns' names end in their units.
recording = pd.read_csv(recording_file, comment="#", index_col="time_s")
stroke_mm = recording["contraction_mm"].max() - recording["contraction_mm"].min()
print(f"{len(recording)} rows over {recording.index[-1]:.1f} s, stroke {stroke_mm:.1f} mm")
print(recording.describe().loc[["min", "mean", "max"]].round(3).to_string())

# A model: tables of numbers whose keys end in their units.
with open(model_file, "rb") as file:
    model = tomllib.load(file)
print(f"model {model['kind']}: {', '.join(key for key, value in model.items() if isinstance(value, dict))}")

# The log of mgpi track or mgpi pil.
log = pd.read_csv(log_file, index_col="time_s")
error_mm = log["contraction_mm"] - log["reference_mm"]
print(f"tracking error: RMSE {(error_mm**2).mean() ** 0.5:.3f} mm, largest {error_mm.abs().max():.3f} mm")
