"""What `mgpi diagnose` writes beside other tools' predictors (`predictors.py`): see README.md.

Needs Python 3.11 or newer with `venv`, and cargo. The first run fetches the peers' packages from PyPI.
"""

import argparse
import csv
import json
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from run import HERE, build, peer_python, succeed

TAUGHT = 2 / 3  # of the recording's time; the rest is predicted
MOST_ROWS = 4000  # of the even clock that the peers are taught on
OURS = ("mgpi identify", "mgpi diagnose")
FIRST = OURS[0]


def number(path, line, name, cell):
    """A cell's number; None where it is empty."""
    try:
        return float(cell) if cell else None
    except ValueError:
        sys.exit(f"error: {path}, line {line}, column {name}: {cell!r} is not a number")


def read(path):
    """A recording's columns by name, as numbers; None in empty cells."""
    try:
        with open(path, newline="") as file:
            rows = [(i, row) for i, row in enumerate(csv.reader(file), 1) if row and not row[0].startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"error: {path}: {error}")
    if len(rows) < 2:
        sys.exit(f"error: {path}: no rows of numbers")
    (_, names), rows = rows[0], rows[1:]
    for line, row in rows:
        if len(row) != len(names):
            sys.exit(f"error: {path}, line {line}: {len(row)} cells, and the heading has {len(names)}")
    return {name: [number(path, line, name, row[i]) for line, row in rows] for i, name in enumerate(names)}


def column(path, columns, wanted, what):
    """The first wanted column that the recording has."""
    for name in wanted:
        if name in columns:
            return name
    sys.exit(f"error: {path}: no {what} column {' or '.join(wanted)}; it has {', '.join(columns)}")


def write(path, columns, rows):
    with open(path, "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(columns)
        for k in rows:
            out.writerow(["" if values[k] is None else repr(values[k]) for values in columns.values()])


def at(times, values, wanted):
    """Straight lines through the known values, at rising times."""
    known = [(t, v) for t, v in zip(times, values) if v is not None]
    answer, i = [], 0
    for t in wanted:
        while i + 2 < len(known) and known[i + 1][0] < t:
            i += 1
        (t0, v0), (t1, v1) = known[i], known[min(i + 1, len(known) - 1)]
        share = 0.0 if t1 == t0 else min(max((t - t0) / (t1 - t0), 0.0), 1.0)
        answer.append(v0 + share * (v1 - v0))
    return answer


def by_mgpi(mgpi, command, options, folder, columns, taught):
    """What a model of the first part says of the whole recording, a value a row; None where there is no model."""
    part, whole = folder / "taught.csv", folder / "whole.csv"
    model, out = folder / f"{command}.toml", folder / f"{command}.csv"
    write(part, columns, range(taught))
    write(whole, columns, range(len(columns["time_s"])))
    names = [f"--input={options.input}", f"--output={options.output}"]
    done = subprocess.run([mgpi, command, part, *names, "-o", model], capture_output=True, text=True)
    if not model.exists():
        return None, done.stderr.strip().splitlines()[-1:]
    simulate = subprocess.run([mgpi, "simulate", model, "--input", whole, "-o", out], capture_output=True, text=True)
    if simulate.returncode:
        return None, simulate.stderr.strip().splitlines()[-1:]
    return read(out)[options.output], []


def by_peers(python, options, columns, taught, plain):
    """What each peer says of the rest, at the recording's own times."""
    times = columns["time_s"]
    step = max(statistics.median(b - a for a, b in zip(times, times[1:])), (times[taught] - times[0]) / MOST_ROWS)
    clock = [times[0] + k * step for k in range(1 + int((times[-1] - times[0]) / step))]
    further = [n for n in ("load_n", "temperature_c") if n in columns and len(set(columns[n])) > 1]
    inputs = [at(times, columns[name], clock) for name in (options.input, *further)]
    split = next(k for k, t in enumerate(clock) if t >= times[taught])
    given = {
        "inputs": inputs,
        "output": at(times[:taught], columns[options.output][:taught], clock[:split]),
        "split": split,
        "plain": at(times, plain, clock),
    }
    command = [python, HERE / "predictors.py"]
    answers = json.loads(succeed(command, "the peers failed", input=json.dumps(given)))
    rest = clock[split:]
    return {name: values and at(rest, values, times[taught:]) for name, values in answers.items()}


def error(measured, simulated, counts):
    """Root mean square over the rows that count; infinite where there is no answer."""
    if simulated is None:
        return math.inf
    squares = [(a - b) ** 2 for a, b, c in zip(measured, simulated, counts) if c and a is not None]
    return math.sqrt(statistics.fmean(squares))


def judge(mgpi, python, path, options):
    """The error of each predictor over the last part of a recording, in the output's unit."""
    columns = read(path)
    times = columns[column(path, columns, ["time_s"], "time")]
    taught = next(k for k, t in enumerate(times) if t >= times[0] + TAUGHT * (times[-1] - times[0]))
    counts = [v != 0 for v in columns.get("valid", [1] * len(times))][taught:]
    options = argparse.Namespace(
        input=column(path, columns, [options.input] if options.input else ["pressure_bar", "command_bar"], "input"),
        output=column(path, columns, [options.output or "contraction_mm"], "output"),
    )
    errors, notes = {}, []
    with tempfile.TemporaryDirectory() as folder:
        for name in OURS:
            command = name.split()[1]
            simulated, why = by_mgpi(mgpi, command, options, Path(folder), columns, taught)
            notes += why
            if name == FIRST and simulated is None:
                sys.exit(f"error: {path}: mgpi identify writes no model of it: {' '.join(why)}")
            plain = simulated if name == FIRST else plain
            errors[name] = error(columns[options.output][taught:], simulated and simulated[taught:], counts)
    for name, simulated in by_peers(python, options, columns, taught, plain).items():
        errors[name] = error(columns[options.output][taught:], simulated, counts)
    return errors, notes


def zoo(mgpi, folder, first, count):
    """Recordings of simulated plants, each with its own hidden causes."""
    paths = []
    for seed in range(first, first + count):
        succeed([mgpi, "rig", "zoo", "--seed", str(seed), "-o", folder], "no plant of the zoo")
        paths.append(Path(folder) / f"{seed}.csv")
    return paths


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", type=Path, nargs="*", help="CSV, as for mgpi diagnose")
    parser.add_argument("--zoo", type=int, default=0, metavar="N", help="also N simulated plants")
    parser.add_argument("--seed", type=int, default=1, help="of the first of them")
    parser.add_argument("--input", help="input column [default: pressure_bar, else command_bar]")
    parser.add_argument("--output", help="output column [default: contraction_mm]")
    options = parser.parse_args()
    if not options.recordings and not options.zoo:
        parser.error("name recordings, or --zoo N")
    mgpi, target = build()
    python = peer_python(target, "requirements-predict.txt")
    ratios = {}
    with tempfile.TemporaryDirectory() as folder:
        paths = options.recordings + zoo(mgpi, folder, options.seed, options.zoo)
        for number, path in enumerate(paths):
            errors, notes = judge(mgpi, python, path, options)
            if number == 0:
                print(f"{'error of the simulation over the last third':44}{FIRST:>14}, and ratios to it")
                print(f"{'':44}{'':14}" + "".join(f"{name:>26}" for name in errors if name != FIRST))
            shown = "".join(f"{errors[n] / errors[FIRST]:26.3f}" for n in errors if n != FIRST)
            print(f"{path.name:44}{errors[FIRST]:14.4f}{shown}", flush=True)
            for note in notes:
                print(f"  {note}")
            for name, value in errors.items():
                ratios.setdefault(name, []).append(value / errors[FIRST])
    means = {name: math.exp(statistics.fmean(math.log(r) for r in all_)) for name, all_ in ratios.items()}
    print(f"{'geometric mean':44}{'':14}" + "".join(f"{means[n]:26.3f}" for n in means if n != FIRST))
    print(f"{'largest':44}{'':14}" + "".join(f"{max(ratios[n]):26.3f}" for n in means if n != FIRST))


if __name__ == "__main__":
    main()
