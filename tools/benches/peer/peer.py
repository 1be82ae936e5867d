"""The peer: what a good Python user of today writes to identify the MGPI model from a recording.

SciPy's `least_squares` moves five nonlinear parameters with finite differences; the dead-zone slopes and the
offset are projected out by `nnls` (variable projection); the forward model is compiled by numba. Bounds,
the least slope and the ranges of the starts are those of `mgpi identify`, so that both search the same
models. Prints a JSON list: of each start the seconds, the RMSE, and whether its model is invertible.
"""

import argparse
import csv
import json
import time

import numpy as np
from numba import njit
from scipy.optimize import least_squares, nnls
from scipy.stats import qmc

LEAST_SLOPE = 1e-2  # share of the mean slope


def logit(share):
    return np.log(share / (1 - share))


def bounds(plays):
    """Lower and upper end of: ln a, b, ln alpha, beta, logit s (see `mgpi`'s module `coordinates`)."""
    low = [np.log(0.02), -4, np.log(0.01 / plays), -1, logit(0.001)]
    high = [np.log(15), 4, np.log(4 / plays), 8, logit(0.999)]
    return np.array(low), np.array(high)


def starts(count, plays):
    """Scrambled Halton points: ln a, b, ln of the largest threshold, ln of the total decay, logit s."""
    low = np.array([np.log(0.4), -2, np.log(0.15), np.log(0.5), -3])
    high = np.array([np.log(4), 1, np.log(1.2), np.log(8), 1.5])
    points = qmc.scale(qmc.Halton(d=5, seed=1).random(count), low, high)
    # From the whole bank to a single step of it.
    points[:, 2] -= np.log(plays)
    points[:, 3] = np.exp(points[:, 3]) / plays
    return points


@njit
def hinges(t, rows, parameters, plays, dead_zones):
    """The way that u has gone inside each dead-zone segment, for each row that counts; and the segments' width."""
    a, b, alpha, beta = np.exp(parameters[0]), parameters[1], np.exp(parameters[2]), parameters[3]
    s = 1 / (1 + np.exp(-parameters[4]))
    r = alpha * np.arange(1, plays + 1)
    p = np.exp(-beta * np.arange(1, plays + 1))
    p *= (1 - s) / p.sum()
    bottom, top = np.tanh(b), np.tanh(a + b)
    width = (s + (p * np.maximum(1 - r, 0)).sum()) / dead_zones
    z = np.zeros(plays)
    ways = np.zeros((len(rows), dead_zones))
    row = 0
    for k in range(len(t)):
        v = (np.tanh(a * t[k] + b) - bottom) / (top - bottom)
        u = s * v
        for i in range(plays):
            z[i] = min(max(z[i], v - r[i]), v + r[i])
            u += p[i] * z[i]
        if row < len(rows) and rows[row] == k:
            ways[row, 0] = min(u, width)
            for j in range(1, dead_zones):
                ways[row, j] = min(max(u - j * width, 0), width)
            if u > dead_zones * width:
                ways[row, -1] = u - (dead_zones - 1) * width
            row += 1
    return ways


def project(ways, y, least_slope, normal_equations):
    """Residuals with the best offset and slopes, and the slopes. Centred columns leave the offset free."""
    columns, target = ways - ways.mean(axis=0), y - y.mean()
    rest = target - columns @ np.full(columns.shape[1], least_slope)
    if normal_equations:  # a few rows instead of all, at the price of the squared condition number
        gram = columns.T @ columns
        factor = np.linalg.cholesky(gram + 1e-10 * gram.max() * np.eye(len(gram)))
        above, _ = nnls(factor.T, np.linalg.solve(factor, columns.T @ rest))
    else:
        above, _ = nnls(columns, rest)
    slopes = above + least_slope
    return columns @ slopes - target, slopes


def identify(t, rows, y, options, start):
    """A search from one start: its RMSE, and whether its model is invertible."""

    def at(parameters):
        ways = hinges(t, rows, parameters, options.plays, options.dead_zones)
        return project(ways, y, LEAST_SLOPE * np.ptp(y), options.normal_equations)

    end = least_squares(lambda parameters: at(parameters)[0], start, bounds=bounds(options.plays), method="trf")
    direct_share = 1 / (1 + np.exp(-end.x[4]))
    return np.sqrt(np.mean(end.fun**2)), bool(min(direct_share, at(end.x)[1].min()) > 0)


def read(options):
    """Input of every row over its span (0 … 1), indices of the rows that count, their outputs."""
    with open(options.recording) as file:
        table = list(csv.DictReader(line for line in file if not line.startswith("#")))
    name = options.input or ("pressure_bar" if "pressure_bar" in table[0] else "command_bar")
    x = np.array([float(row[name]) for row in table])
    y = np.array([float(row[options.output]) for row in table])
    rows = np.array([k for k, row in enumerate(table) if float(row.get("valid") or 1) != 0])
    return (x - x.min()) / np.ptp(x), rows, y[rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording")
    parser.add_argument("--starts", type=int, default=24)
    parser.add_argument("--plays", type=int, default=10)
    parser.add_argument("--dead-zones", type=int, default=10)
    parser.add_argument("--normal-equations", action="store_true")
    parser.add_argument("--input")
    parser.add_argument("--output", default="contraction_mm")
    options = parser.parse_args()
    t, rows, y = read(options)
    points = starts(options.starts, options.plays)
    hinges(t[:100], rows[rows < 100], points[0], options.plays, options.dead_zones)  # compiles

    searches = []
    for point in points:
        begin = time.perf_counter()
        rmse, invertible = identify(t, rows, y, options, point)
        seconds = time.perf_counter() - begin
        searches.append({"seconds": seconds, "rmse": rmse, "invertible": invertible})
    print(json.dumps(searches))


if __name__ == "__main__":
    main()
