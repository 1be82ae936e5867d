# %% [markdown]
# # A first model of a muscle
#
# Ten minutes, from a recording to a model that knows what it does not know. A notebook in script form: Jupyter opens
# it by jupytext, Visual Studio Code and Spyder as it is, and `python3 first_model.py` runs it from one end to the
# other. It needs `mgpi`; pandas and matplotlib make tables and pictures of it.

# %%
import numpy as np

import mgpi

# %% [markdown]
# ## 1. A recording
#
# Six slow triangles of pressure, from 6 bar down to 1 bar, on a simulated muscle. Yours may be a CSV, a DataFrame, or
# arrays: `mgpi.Recording({"time_s": t, "pressure_bar": p, "contraction_mm": x})`.

# %%
recording = mgpi.Recording("recordings/rig-fig8.csv")
print(recording)

# %% [markdown]
# Up and down are two branches: the same pressure does not tell a length. How far are they apart in the middle?

# %%
pressure, contraction = recording.input, recording.output
rising = np.gradient(pressure) > 0.0
middle = np.abs(pressure - 3.0) < 0.05
up, down = contraction[middle & rising].mean(), contraction[middle & ~rising].mean()
print(f"at 3 bar: {up:.1f} mm on the way up, {down:.1f} mm on the way down")

# %% [markdown]
# ## 2. A model
#
# The modified generalized Prandtl-Ishlinskii model: an envelope, ten plays, ten dead zones. `holdout=True` also fits a
# model of the first half of the cycles, and tries it on the second.

# %%
identifier = mgpi.Identifier(plays=10, dead_zones=10, starts=8, holdout=True).fit(recording)
model = identifier.model_
print(model)
print(model.worth)
print(identifier.parameters_)

# %% [markdown]
# On a recording of another kind, sixty random ramps, that took no part:

# %%
ramps = mgpi.Recording("recordings/rig-ramps.csv")
figures = ramps.figures(identifier.predict(ramps))
print(f"RMSE {figures['rmse_mm']:.2f} mm, {100.0 * figures['rmse_mm'] / ramps.stroke:.2f} % of stroke")
assert figures["rmse_mm"] < 0.02 * ramps.stroke

# %% [markdown]
# **Try it:** fewer plays (`plays=2`), another model (`"cpi"`, `"sgpi"`), both recordings (`fit([recording, ramps])`).
# Which of them does better on what it has not seen, and which only on what it has?

# %%
for name, plays in [("cpi", 10), ("sgpi", 10), ("mgpi", 2)]:
    other = mgpi.Identifier(name, plays=plays, starts=4).fit(recording)
    error = ramps.figures(other.predict(ramps))["rmse_mm"]
    print(f"{name:5} {plays:2} plays: RMSE {error:.2f} mm on the ramps")

# %% [markdown]
# ## 3. The inverse
#
# Which pressure brings the muscle to where you want it? The inverse knows the branch.

# %%
wanted = 60.0 - 50.0 * np.cos(np.linspace(0.0, 4.0 * np.pi, 400))
needed = model.inverse(wanted)
print(f"largest error of model after inverse: {np.abs(model.simulate(needed) - wanted).max():.1e} mm")

# %% [markdown]
# ## 4. What the model gets wrong, and why
#
# The muscle of this recording is no Prandtl-Ishlinskii operator: it has friction, air and a valve. `diagnose` says what
# of that the recording shows, and what it does not tell apart.

# %%
diagnosis = mgpi.diagnose(recording)
print(diagnosis.sentence)
for row in diagnosis.rows:
    print(row["role"], row["cause"], row["evidence"])
diagnosis  # a table, in a notebook

# %% [markdown]
# ## 5. A picture, and the file
#
# `model.toml` is what `mgpi pil` and `mgpi deploy` take. `identifier.report()` is a page with everything in it.

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("pip install matplotlib draws the loops")
else:
    figure, axes = plt.subplots()
    axes.plot(pressure, contraction, label="measured")
    axes.plot(pressure, identifier.predict(recording), label="model")
    axes.set_xlabel("pressure (bar)")
    axes.set_ylabel("contraction (mm)")
    axes.legend()
    figure.savefig("loops.png")

model.save("model.toml", overwrite=True)
assert mgpi.Model.load("model.toml") == model
