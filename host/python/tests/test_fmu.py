"""Units of FMI, run by FMPy, are the command's model."""

import pathlib

import fmpy
import numpy as np
import pandas as pd
import pytest
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

ROOT = pathlib.Path(__file__).parents[3]
TESTS = ROOT / "host" / "mgpi" / "tests" / "common"


@pytest.fixture(scope="module")
def models(command, recordings, tmp_path_factory):
    """An identified model, one with turning points, and one with every extension."""
    folder = tmp_path_factory.mktemp("models")
    command("identify", recordings / "rig-fig8.csv", "-o", folder / "plain.toml", "--starts", 2)
    command("identify", recordings / "rig-fig8.csv", "-o", folder / "many.toml", "--starts", 2, "--plays", 40)
    paper = (ROOT / "examples" / "paper-tables-1-2.toml").read_text()
    paper = paper.replace('column = "pressure_bar"', 'column = "command_bar"')
    text = paper + "\n" + (TESTS / "every_extension.toml").read_text()
    (folder / "extended.toml").write_text(text)
    return folder


def recording(file, drive):
    """Swings at unequal steps."""
    time_s = 0.01 * np.arange(2000) + 0.004 * (np.arange(2000) % 3)
    rows = pd.DataFrame({"time_s": time_s, drive: 3.0 + 3.0 * np.exp(-0.05 * time_s) * np.sin(5.0 * time_s - 1.5)})
    rows["load_n"] = 20.0 + 5.0 * np.sin(time_s)
    rows["temperature_c"] = 25.0 + 0.1 * time_s
    rows.to_csv(file, index=False)
    return pd.read_csv(file)


class Running:
    """An instance, driven by names."""

    def __init__(self, unit, folder, said=None):
        description = fmpy.read_model_description(unit, validate=True)
        assert description.fmiVersion == "3.0"
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        if not folder.exists():
            fmpy.extract(unit, folder)
        self.slave = FMU3Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        say = None if said is None else lambda _env, _status, _category, message: said.append(message.decode())
        self.slave.instantiate(logMessage=say)

    def go(self, rows, answer, begin, end):
        """The answers to the rows from `begin` to `end`: an input is set, then a step is made to its time."""
        names = [name for name in rows if name in self.references and name != answer]
        references = [self.references[name] for name in names]
        values, time_s, answers = rows[names].to_numpy(), rows["time_s"].to_numpy(), []
        for row in range(begin, end):
            if row == 0:
                self.slave.enterInitializationMode(startTime=time_s[0])
            self.slave.setFloat64(references, list(values[row]))
            if row == 0:
                self.slave.exitInitializationMode()
            else:
                self.slave.doStep(time_s[row - 1], time_s[row] - time_s[row - 1])
            answers.append(self.slave.getFloat64([self.references[answer]])[0])
        return np.array(answers)


@pytest.mark.parametrize("name", ["plain", "many", "extended"])
def test_a_unit_answers_as_the_command_and_goes_on_from_a_saved_state(command, models, tmp_path, name):
    model, drive = models / f"{name}.toml", "command_bar" if name == "extended" else "pressure_bar"
    rows = recording(tmp_path / "rec.csv", drive)
    command("simulate", model, "--input", tmp_path / "rec.csv", "-o", tmp_path / "out.csv")
    wanted = pd.read_csv(tmp_path / "out.csv")["contraction_mm"].to_numpy()
    command("export", model, "--fmu", tmp_path / "unit.fmu")
    rows = rows.drop(columns=[] if name == "extended" else ["load_n", "temperature_c"])
    running = Running(tmp_path / "unit.fmu", tmp_path / "one")
    assert set(rows) - {"time_s"} <= set(running.references)
    answers = running.go(rows, "contraction_mm", 0, 1000)
    state = running.slave.getFMUState()
    saved = running.slave.serializeFMUState(state)
    rest = running.go(rows, "contraction_mm", 1000, 2000)
    assert np.array_equal(np.concatenate([answers, rest]), wanted)
    # Back to the state, in the same instance and, by its bytes, in another one.
    running.slave.setFMUState(state)
    assert np.array_equal(running.go(rows, "contraction_mm", 1000, 2000), rest)
    other = Running(tmp_path / "unit.fmu", tmp_path / "other")
    other.slave.setFMUState(other.slave.deserializeFMUState(saved))
    assert np.array_equal(other.go(rows, "contraction_mm", 1000, 2000), rest)
    running.slave.freeFMUState(state)
    print(f"{name}: {len(wanted)} rows, {len(saved)} bytes of state")


def test_an_inverse_answers_as_the_package(command, models, tmp_path):
    mgpi = pytest.importorskip("mgpi")
    period_s = 0.01
    time_s = period_s * np.arange(1000)
    rows = pd.DataFrame({"time_s": time_s, "wanted_contraction_mm": 60.0 + 30.0 * np.sin(3.0 * time_s)})
    rows["load_n"], rows["temperature_c"] = 22.0, 25.5
    model = models / "extended.toml"
    command("export", model, "--fmu", tmp_path / "unit.fmu", "--inverse", "--period-s", period_s)
    running = Running(tmp_path / "unit.fmu", tmp_path / "one")
    answers = running.go(rows, "command_bar", 0, 500)
    saved = running.slave.serializeFMUState(running.slave.getFMUState())
    other = Running(tmp_path / "unit.fmu", tmp_path / "other")
    other.slave.setFMUState(other.slave.deserializeFMUState(saved))
    answers = np.concatenate([answers, other.go(rows, "command_bar", 500, 1000)])
    native = mgpi.Model.load(model).inverse(
        rows["wanted_contraction_mm"].to_numpy(),
        period_s=period_s,
        load_n=rows["load_n"].to_numpy(),
        temperature_c=rows["temperature_c"].to_numpy(),
    )
    assert np.array_equal(answers, native)


def test_fmpy_simulates_a_unit_by_itself(command, models, tmp_path):
    model = models / "plain.toml"
    command("export", model, "--fmu", tmp_path / "unit.fmu", "--name", "biceps")
    assert validate_fmu(str(tmp_path / "unit.fmu")) == []
    time_s = 0.01 * np.arange(500)
    signal = np.array(list(zip(time_s, 3.0 - 3.0 * np.cos(3.0 * time_s))), dtype=[("time", float), ("pressure_bar", float)])
    result = fmpy.simulate_fmu(
        str(tmp_path / "unit.fmu"), validate=True, step_size=0.01, output_interval=0.01, stop_time=4.99, input=signal
    )
    # An input holds for the step that begins with it.
    pressure = np.concatenate([signal["pressure_bar"][:1], signal["pressure_bar"][:-1]])
    pd.DataFrame({"time_s": time_s, "pressure_bar": pressure}).to_csv(tmp_path / "rec.csv", index=False)
    command("simulate", model, "--input", tmp_path / "rec.csv", "-o", tmp_path / "out.csv")
    wanted = pd.read_csv(tmp_path / "out.csv")["contraction_mm"].to_numpy()
    assert np.allclose(result["contraction_mm"], wanted[: len(result)], rtol=0.0, atol=1e-9)
    assert len(result) == len(wanted)


def test_what_is_wrong_is_said(command, models, tmp_path):
    unit = tmp_path / "unit.fmu"
    command("export", models / "extended.toml", "--fmu", unit, "--inverse", "--period-s", 0.01)
    said = []
    running = Running(unit, tmp_path / "one", said)

    def refused(call):
        with pytest.raises(Exception):
            call()
        return said.pop()

    slave, references = running.slave, running.references
    assert "not possible in mode Instantiated" in refused(lambda: slave.doStep(0.0, 0.01))
    slave.enterInitializationMode()
    assert "no finite number" in refused(lambda: slave.setFloat64([references["wanted_contraction_mm"]], [np.nan]))
    assert "no variable 77" in refused(lambda: slave.getFloat64([77]))
    slave.exitInitializationMode()
    assert "is an output" in refused(lambda: slave.setFloat64([references["command_bar"]], [1.0]))
    assert "no multiple of the inverse's period" in refused(lambda: slave.doStep(0.0, 0.0123))
    assert "no state of a unit" in refused(lambda: slave.deserializeFMUState(b"\x05a"))
    assert "Float64" in refused(lambda: slave.getInt32([1]))
    # Another model behind the same description.
    file = tmp_path / "one" / "resources" / "model.toml"
    file.write_text(file.read_text().replace("delay_s = 0.015", "delay_s = 0.025"))
    with pytest.raises(Exception, match="Failed to instantiate"):
        Running(unit, tmp_path / "one", said)
    assert "not those that the unit was exported with" in said.pop()
