"""Diagnoses an archive of recordings by dask, on this machine or on a cluster: a line a recording.

    python with_dask.py recordings -o results.csv                  # two worker processes here
    python with_dask.py recordings -o results.csv --workers 8
    python with_dask.py recordings -o results.csv --scheduler tcp://head:8786
    python with_dask.py recordings -o results.csv --slurm 20       # by dask-jobqueue, as jobs of SLURM
    python with_dask.py recordings -o results.csv --workers 0      # one after the other, without dask

The lines are the same however they are made. A file that is no recording gets a line that says why; the recordings of a
worker that dies are done by another one.
"""

import argparse
import csv
import pathlib
import sys

import mgpi

COLUMNS = ["file", "error", "samples", "stroke", "verdict", "causes", "plain_rmse_mm", "written_rmse_mm"]


def diagnosed(file):
    """The line of a recording."""
    line = dict.fromkeys(COLUMNS, "") | {"file": file}
    try:
        recording = mgpi.Recording(file)
        diagnosis = mgpi.diagnose(recording)
    except (mgpi.DataError, mgpi.DiagnosisError, OSError) as error:
        return line | {"error": str(error)}
    result = diagnosis.result
    causes = " + ".join(cause["name"] for cause in result["causes"])
    return line | {
        "samples": len(recording),
        "stroke": recording.stroke,
        "verdict": diagnosis.verdict,
        "causes": causes,
        "plain_rmse_mm": result["baseline"].get("rmse_mm", ""),
        "written_rmse_mm": result["extended"].get("rmse_mm", ""),
    }


def client(options):
    """What the work is sent to. A process works on one recording at a time, so that many do not share a core."""
    from dask.distributed import Client, LocalCluster

    if options.scheduler:
        return Client(options.scheduler)
    if options.slurm:
        from dask_jobqueue import SLURMCluster

        cluster = SLURMCluster(cores=1, processes=1, memory="2GB", job_script_prologue=["export RAYON_NUM_THREADS=1"])
        cluster.scale(options.slurm)
        return Client(cluster)
    environment = {"RAYON_NUM_THREADS": "1"}
    return Client(LocalCluster(n_workers=options.workers, threads_per_worker=1, env=environment, dashboard_address=None))


def lines(files, options):
    """The lines of all files, in their order."""
    if not (options.workers or options.scheduler or options.slurm):
        return [diagnosed(file) for file in files]
    from dask.distributed import as_completed

    with client(options) as dask:
        # Not pure: a file may have changed since a scheduler that lives longer has seen it.
        futures = dask.map(diagnosed, files, pure=False)
        place = {future.key: row for row, future in enumerate(futures)}
        found = [None] * len(files)
        for done, (future, line) in enumerate(as_completed(futures, with_results=True), 1):
            found[place[future.key]] = line
            print(f"{done} of {len(files)}: {line['file']}: {line['verdict'] or line['error']}", file=sys.stderr)
        return found


def main():
    parser = argparse.ArgumentParser(description="Diagnoses an archive of recordings by dask.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--workers", type=int, default=2, help="worker processes on this machine; 0: without dask")
    parser.add_argument("--scheduler", help="address of a scheduler that runs already")
    parser.add_argument("--slurm", type=int, metavar="JOBS", help="jobs of SLURM, by dask-jobqueue")
    options = parser.parse_args()
    if options.output.exists():
        parser.error(f"{options.output} exists already")
    files = sorted(str(file) for file in options.folder.rglob("*.csv"))
    if not files:
        parser.error(f"there is no .csv in {options.folder}")
    found = lines(files, options)
    part = options.output.with_name(options.output.name + ".part")
    with part.open("w", newline="") as output:
        writer = csv.DictWriter(output, COLUMNS)
        writer.writeheader()
        writer.writerows(found)
    part.replace(options.output)


if __name__ == "__main__":
    main()
