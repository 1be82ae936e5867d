"""`mgpi identify` beside its peer (`peer.py`), on the same recording, one thread each: see README.md.

Needs Python 3.11 or newer with `venv`, and cargo. The first run fetches the peer's packages from PyPI.
"""

import argparse
import hashlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA")}
NEAR = 1.05  # a start within 5 % of the best has found it
SEEDS = (1, 2, 3)  # of the whole identifications by mgpi
HEADING = """\
                              s a start                  within               ratio of
                                median    least      RMSE    5 %  invertible  medians  leasts"""


def succeed(command, why, **options):
    """Standard output of a command; ends the program with `why` where it does not succeed."""
    try:
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"error: {why}: {error}")


def build():
    """Builds `mgpi`; its path and the target directory."""
    succeed(["cargo", "build", "--release", "-p", "mgpi"], "mgpi cannot be built", cwd=ROOT)
    metadata = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    target = Path(json.loads(succeed(metadata, "no cargo metadata", cwd=ROOT))["target_directory"])
    return target / "release" / "mgpi", target


def peer_python(target, requirements="requirements.txt"):
    """The Python of the peers' environment, which is made at the first run and when a pinned version changes."""
    requirements = HERE / requirements
    folder = target / requirements.stem.replace("requirements", "peer-venv")
    python, stamp = folder / "bin" / "python", folder / "installed"
    digest = hashlib.sha256(requirements.read_bytes()).hexdigest()
    if not stamp.exists() or stamp.read_text() != digest:
        print(f"installing the peer's packages into {folder}", flush=True)
        try:
            venv.create(folder, clear=True, with_pip=True)
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"error: no virtual environment (Debian: apt-get install python3-venv): {error}")
        install = [python, "-m", "pip", "install", "--quiet", "--requirement", requirements]
        succeed(install, "the peer's packages cannot be had; the first run needs PyPI, so a network")
        stamp.write_text(digest)
    return python


def run_peer(python, options, *more):
    """The starts of the peer."""
    command = [python, HERE / "peer.py", options.recording, *sizes(options), "--starts", str(options.starts), *more]
    return json.loads(succeed(command, "the peer failed", env=os.environ | ONE_THREAD))


def run_mgpi(mgpi, options, starts, seed):
    """An identification by mgpi: seconds by the number of starts, RMSE, invertible or not."""
    with tempfile.TemporaryDirectory() as folder:
        model, figures = Path(folder) / "model.toml", Path(folder) / "figures.json"
        run = ["--starts", str(starts), "--seed", str(seed), "--threads", "1", "-o", model, "--json", figures]
        succeed([mgpi, "identify", options.recording, *sizes(options), *run], "mgpi failed")
        figures = json.loads(figures.read_text())
    rmse = next(value for key, value in figures["training"].items() if key.startswith("rmse"))
    return {"seconds": figures["seconds"] / starts, "rmse": rmse, "invertible": figures["invertible"]}


def sizes(options):
    columns = [f"--{name}={value}" for name in ("input", "output") if (value := getattr(options, name))]
    return ["--plays", str(options.plays), "--dead-zones", str(options.dead_zones), *columns]


def figures(searches):
    """Seconds a start (median, least), best RMSE, share of the searches near it, whether its model is invertible."""
    seconds = [search["seconds"] for search in searches]
    best = min(searches, key=lambda search: search["rmse"])
    share = sum(search["rmse"] <= NEAR * best["rmse"] for search in searches) / len(searches)
    return statistics.median(seconds), min(seconds), best["rmse"], share, best["invertible"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", type=Path, help="CSV, as for mgpi identify")
    parser.add_argument("--starts", type=int, default=24)
    parser.add_argument("--plays", type=int, default=10)
    parser.add_argument("--dead-zones", type=int, default=10)
    parser.add_argument("--input", help="input column")
    parser.add_argument("--output", help="output column")
    options = parser.parse_args()
    mgpi, target = build()
    python = peer_python(target)

    one_by_one = [run_mgpi(mgpi, options, 1, seed) for seed in range(1, options.starts + 1)]
    as_shipped = [run_mgpi(mgpi, options, options.starts, seed) for seed in SEEDS]
    rows = {
        "SciPy": figures(run_peer(python, options)),
        "SciPy, normal equations": figures(run_peer(python, options, "--normal-equations")),
        f"mgpi, {options.starts} starts, {len(SEEDS)} runs": figures(as_shipped),
        "mgpi, every start to its end": figures(one_by_one),
    }
    print(f"{options.recording.name}, {options.plays} plays, {options.dead_zones} dead zones, one thread each")
    print(HEADING)
    scipy_median, scipy_least = rows["SciPy"][:2]
    for name, (median, least, rmse, near, invertible) in rows.items():
        ratios = f"{scipy_median / median:8.1f}{scipy_least / least:8.1f}"
        print(f"{name:30}{median:9.4f}{least:9.4f}{rmse:10.4f}{near:8.0%}{'yes' if invertible else 'no':>12}{ratios}")


if __name__ == "__main__":
    main()
