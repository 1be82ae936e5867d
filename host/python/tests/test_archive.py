"""An archive by other engines is the archive done one after the other."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

EXAMPLES = pathlib.Path(__file__).parents[3] / "examples" / "archive"
# As many recordings as dask is given; more on demand.
RECORDINGS = int(os.environ.get("MGPI_RECORDINGS", 12))


@pytest.fixture(scope="module")
def archive(command, tmp_path_factory):
    """Short recordings of simulated muscles, and a file that is none."""
    folder = tmp_path_factory.mktemp("archive")
    (folder / "recordings" / "march").mkdir(parents=True)
    for seed in range(RECORDINGS):
        name = f"march/{seed}.csv" if seed % 4 == 3 else f"{seed}.csv"
        file = folder / "recordings" / name
        hidden = ["--hide", "creep"] if seed % 3 == 1 else []
        command("rig", "record", "--protocol", "ramps", "--seed", seed, "--rate-hz", 10, *hidden, "-o", file)
        # Half a minute of it is diagnosed in no time.
        file.write_text("".join(file.read_text().splitlines(keepends=True)[:400]))
    (folder / "recordings" / "broken.csv").write_text("time_s,pressure_bar,contraction_mm\n0,0,0\n0.1,touched,1\n")
    return folder


def test_a_worker_that_is_killed_costs_nothing(archive, tmp_path):
    pytest.importorskip("distributed")
    psutil = pytest.importorskip("psutil")
    script = [sys.executable, EXAMPLES / "with_dask.py", "recordings"]
    begin = time.monotonic()
    subprocess.run([*script, "-o", tmp_path / "serial.csv", "--workers", "0"], cwd=archive, check=True)
    serial_s = time.monotonic() - begin
    begin = time.monotonic()
    with (tmp_path / "said").open("w") as said:
        running = subprocess.Popen([*script, "-o", tmp_path / "dask.csv"], cwd=archive, stderr=said)
        killed = None
        while running.poll() is None:
            done = (tmp_path / "said").read_text().count(" of ")
            if killed is None and done > RECORDINGS // 3:
                all_of_it = psutil.Process(running.pid).children(recursive=True)
                workers = [process for process in all_of_it if "spawn_main" in " ".join(process.cmdline())]
                assert len(workers) == 2, workers
                killed = workers[0].pid
                os.kill(killed, signal.SIGKILL)
            time.sleep(0.05)
    assert running.returncode == 0, (tmp_path / "said").read_text()
    assert killed is not None
    dask_s = time.monotonic() - begin
    serial, dask = (tmp_path / name for name in ("serial.csv", "dask.csv"))
    assert serial.read_text() == dask.read_text()
    assert serial.read_text().count("\n") == RECORDINGS + 2 and "touched" in serial.read_text()
    print(f"{RECORDINGS} recordings: one after the other {serial_s:.1f} s, two workers, one killed, {dask_s:.1f} s")


def test_an_array_job_has_the_lines_of_one_run(archive, command, tmp_path):
    program = pathlib.Path(os.environ["MGPI_COMMAND"])
    path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"
    few = tmp_path / "recordings"
    few.mkdir()
    for name in ("0.csv", "1.csv", "2.csv", "broken.csv"):
        (few / name).write_text((archive / "recordings" / name).read_text())
    subprocess.run([program, "batch", "recordings", "-o", "whole.csv"], cwd=tmp_path, check=True, capture_output=True)
    # Twice: what is done already is left alone. More tasks than files: some have nothing to do.
    for task in [*range(6), 0]:
        environment = os.environ | {"SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "6", "PATH": path}
        job = [EXAMPLES / "array-job.sh", "recordings/"]
        subprocess.run(job, cwd=tmp_path, env=environment, check=True, capture_output=True)
    join = "head -n 1 shares/results-0.csv > results.csv; tail -q -n +2 shares/results-*.csv | LC_ALL=C sort >> results.csv"
    subprocess.run(["bash", "-c", join], cwd=tmp_path, check=True)
    wanted = (tmp_path / "whole.csv").read_text().splitlines()
    assert (tmp_path / "results.csv").read_text().splitlines() == [wanted[0], *sorted(wanted[1:])]


def test_the_table_as_parquet_has_figures_as_numbers(archive, command, tmp_path):
    pandas = pytest.importorskip("pandas")
    few = tmp_path / "recordings"
    few.mkdir()
    for name in ("0.csv", "1.csv", "broken.csv"):
        (few / name).write_text((archive / "recordings" / name).read_text())
    for output in ("results.csv", "results.parquet"):
        command("batch", few, "-o", tmp_path / output)
    ours, text = pandas.read_parquet(tmp_path / "results.parquet"), pandas.read_csv(tmp_path / "results.csv")
    assert list(ours) == list(text)
    for name in ("stroke", "written_rmse", "noise_floor"):
        assert ours[name].dtype == "float64" and ours[name].equals(text[name]), name
    assert ours["verdict"].isna().tolist() == [False, False, True]
    assert "touched" in ours["error"][2]
