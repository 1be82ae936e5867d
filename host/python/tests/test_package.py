"""What the package claims beside the numbers."""

import os
import pickle
import signal
import threading
import time

import numpy as np
import pandas as pd
import pytest

import mgpi

TIME_S = np.arange(0.0, 60.0, 0.02)
PRESSURE_BAR = 3.0 - 3.0 * np.cos(0.4 * TIME_S)


def muscle(top=6.0):
    """A recording of a play with a gain: 10 mm/bar, half of it with a play of 0.5 bar."""
    pressure = PRESSURE_BAR * top / 6.0
    held, contraction = 0.0, []
    for x in pressure:
        held = min(max(held, x - 0.5), x + 0.5)
        contraction.append(5.0 * (x + held))
    return {"time_s": TIME_S, "pressure_bar": pressure, "contraction_mm": np.array(contraction)}


def fitted(**kwargs):
    return mgpi.Identifier("cpi", plays=4, starts=2, **kwargs).fit(mgpi.Recording(muscle()))


def test_a_bad_value_is_named_by_row_and_column():
    bad = muscle()
    bad["pressure_bar"] = bad["pressure_bar"].copy()
    bad["pressure_bar"][17] = np.inf
    with pytest.raises(mgpi.DataError, match="arrays, row 17, column pressure_bar: `inf` is not finite") as raised:
        mgpi.Recording(bad)
    assert (raised.value.row, raised.value.column, raised.value.line) == (17, "pressure_bar", None)
    frame = pd.DataFrame(muscle())
    frame["contraction_mm"] = frame["contraction_mm"].astype(object)
    frame.loc[5, "contraction_mm"] = "touched"
    with pytest.raises(mgpi.DataError, match="row 5, column contraction_mm: `touched` is not a number") as raised:
        mgpi.Recording(frame)
    assert raised.value.row == 5


def test_a_bad_file_is_named_by_line_and_column(tmp_path):
    file = tmp_path / "rec.csv"
    file.write_text("time_s,pressure_bar,contraction_mm\n0,0,0\n0.1,x,1\n0.2,2,2\n")
    with pytest.raises(mgpi.DataError, match="line 3, column pressure_bar") as raised:
        mgpi.Recording(file)
    assert (raised.value.line, raised.value.row) == (3, None)


def test_lengths_names_and_times_are_looked_at():
    with pytest.raises(mgpi.DataError, match="column pressure_bar: 10 values where the first column has 3000"):
        mgpi.Recording({**muscle(), "pressure_bar": np.zeros(10)})
    with pytest.raises(mgpi.DataError, match="no column"):
        mgpi.Recording({"time_s": TIME_S, "contraction_mm": TIME_S})
    back = muscle()
    back["time_s"] = TIME_S[::-1].copy()
    with pytest.raises(mgpi.DataError, match="time goes back") as raised:
        mgpi.Recording(back)
    assert raised.value.row == 1


def test_other_names_and_units_are_said_as_for_the_command():
    data = muscle()
    psi = {"t": TIME_S * 1000.0, "p": data["pressure_bar"] * 14.503773773020923, "x": data["contraction_mm"]}
    recording = mgpi.Recording(psi, columns={"time": "t:ms", "pressure": "p:psi", "contraction": "x:mm"})
    assert recording.input_unit == "psi" and abs(recording.stroke - mgpi.Recording(data).stroke) < 1e-9
    stamped = pd.DataFrame(data).drop(columns="time_s")
    stamped.index = pd.Timestamp("2026-03-01") + pd.to_timedelta(TIME_S, unit="s")
    assert np.allclose(mgpi.Recording(stamped).time_s, TIME_S, atol=1e-8)


def test_a_missing_output_is_history():
    data = muscle()
    data["contraction_mm"] = data["contraction_mm"].copy()
    data["contraction_mm"][100:110] = np.nan
    recording = mgpi.Recording(data)
    assert not recording.scored[100:110].any() and recording.scored[110:].all()


def test_model_and_inverse_undo_each_other_and_come_back_from_a_file(tmp_path):
    model = fitted().model_
    wanted = np.linspace(5.0, 45.0, 50)
    assert np.allclose(model.simulate(model.inverse(wanted)), wanted, atol=1e-9)
    model.save(tmp_path / "m.toml")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        model.save(tmp_path / "m.toml")
    again = mgpi.Model.load(tmp_path / "m.toml")
    assert again == model and pickle.loads(pickle.dumps(model)) == model
    assert np.array_equal(again.simulate(PRESSURE_BAR), model.simulate(PRESSURE_BAR))
    with pytest.raises(mgpi.ModelError, match="m2.toml"):
        mgpi.Model.load(tmp_path / "m2.toml")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["m.toml"]


def test_several_recordings_make_one_model_and_bad_ones_are_refused_by_name():
    one, other = mgpi.Recording(muscle(), name="one"), mgpi.Recording(muscle(4.0), name="other")
    both = mgpi.Identifier("cpi", plays=4, starts=2, holdout=True).fit([one, other])
    assert len(both.result_["recordings"]) == 2 and both.heldout_ is not None
    assert both.score(other) > 0.99
    kpa = {**muscle(4.0)}
    kpa["pressure_kpa"] = 100.0 * kpa.pop("pressure_bar")
    with pytest.raises(mgpi.DataError, match="other, column pressure_kpa: .* one has pressure_bar in bar"):
        mgpi.Identifier("cpi").fit([one, mgpi.Recording(kpa, name="other")])
    with pytest.raises(mgpi.DataError, match="the same recording as one"):
        mgpi.Identifier("cpi").fit([one, mgpi.Recording(muscle(), name="again")])


def slow():
    """A search of many seconds."""
    rng = np.random.default_rng(1)
    time_s = np.arange(200_000) / 100.0
    pressure = 3.0 - 3.0 * np.cos(0.3 * time_s) * np.cos(0.011 * time_s)
    data = {"time_s": time_s, "pressure_bar": pressure, "contraction_mm": 10.0 * pressure + rng.normal(size=len(time_s))}
    return mgpi.Recording(data)


def test_an_interruption_ends_the_work_soon():
    recording = slow()
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    begin = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        mgpi.Identifier("egpi", plays=32, starts=200).fit(recording)
    assert time.monotonic() - begin < 5.0
    # And all is as before.
    assert fitted().score(mgpi.Recording(muscle())) > 0.999


def test_what_a_callback_raises_ends_the_work():
    class Enough(Exception):
        pass

    told = []

    def progress(share, what):
        told.append((share, what))
        if share > 0.0:
            raise Enough

    with pytest.raises(Enough):
        mgpi.Identifier("egpi", plays=32, starts=200).fit(slow(), progress=progress)
    assert told[-1][1] == "identifying" and 0.0 < told[-1][0] < 1.0
    with pytest.raises(Enough):
        mgpi.diagnose(mgpi.Recording(muscle()), progress=progress)


def test_other_threads_go_on_beside_the_work():
    counted = []

    def count():
        while not done.is_set():
            counted.append(1)
            time.sleep(0.001)

    done = threading.Event()
    thread = threading.Thread(target=count)
    thread.start()
    mgpi.Identifier(plays=10, starts=24).fit(mgpi.Recording(muscle()))
    done.set()
    thread.join()
    assert len(counted) > 20


def test_a_diagnosis_is_a_table():
    diagnosis = mgpi.diagnose(mgpi.Recording(muscle()))
    assert diagnosis.verdict in ("adequate", "explained", "confounded", "unexplained")
    assert list(diagnosis.to_frame().columns)[:2] == ["cause", "role"]
    page = diagnosis._repr_html_()
    assert diagnosis.verdict in page and page.count("<tr>") == (len(diagnosis.rows) + 1 if diagnosis.rows else 0)
    assert diagnosis.to_html().startswith("<!DOCTYPE html>")


def test_parameters_are_those_of_the_constructor():
    identifier = mgpi.Identifier(plays=7)
    assert identifier.get_params()["plays"] == 7
    assert identifier.set_params(plays=8).plays == 8
    with pytest.raises(ValueError, match="players is no parameter"):
        identifier.set_params(players=8)
    with pytest.raises(mgpi.IdentificationError, match="known are"):
        mgpi.Identifier("mpgi").fit(mgpi.Recording(muscle()))
    with pytest.raises(mgpi.IdentificationError, match="number of plays is 0, must be 1 to 128"):
        mgpi.Identifier(plays=0).fit(mgpi.Recording(muscle()))
