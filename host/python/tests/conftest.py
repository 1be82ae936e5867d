"""The project's recordings, and the command that results are held against."""

import json
import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[3]


@pytest.fixture(scope="session")
def recordings():
    return ROOT / "recordings"


@pytest.fixture(scope="session")
def command():
    """Runs mgpi, and reads the JSON that it writes."""
    program = os.environ.get("MGPI_COMMAND")
    if program is None:
        pytest.skip("MGPI_COMMAND names no mgpi to hold the results against")

    def run(*arguments, json_file=None):
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(pathlib.Path(json_file).read_text()) if json_file else done.stdout

    return run


@pytest.fixture(scope="session")
def made(command, tmp_path_factory):
    """Ten recordings of simulated muscles: protocols, hidden effects, seeds."""
    folder = tmp_path_factory.mktemp("made")
    kinds = [("ramps", "none", 1), ("ramps", "none", 2), ("rich", "viscous_lag", 3), ("rich", "creep", 4)]
    kinds += [("rich", "load", 5), ("rich", "temperature", 6), ("holds", "none", 7), ("rates", "inertia", 8)]
    files = [ROOT / "recordings" / "rig-fig8.csv", ROOT / "recordings" / "rig-ramps.csv"]
    for protocol, effect, seed in kinds:
        file = folder / f"{protocol}-{effect}-{seed}.csv"
        rate = ["--rate-hz", 50] if protocol != "rich" else []
        hidden = ["--hide", effect] if effect != "none" else []
        command("rig", "record", "--protocol", protocol, *hidden, "--seed", seed, *rate, "-o", file)
        files.append(file)
    return files
