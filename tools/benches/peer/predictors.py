"""What other tools make of a recording, each in the way that its own guide says: see README.md.

Every predictor is taught on the first part of a recording, on an even clock, and then runs free: over the rest it
gets the inputs alone, and of the output no more than the values before the rest begins. Where it has something to
choose, it tries each choice on the last quarter of what it is taught with, simulated as well.

Reads a JSON object on standard input and prints one: of each predictor the simulated output over the rest, or null
where it grows without bound.
"""

import json
import sys
import warnings

import numpy as np
import pysindy
from scipy.optimize import least_squares
from sklearn.ensemble import RandomForestRegressor
from sklearn.neural_network import MLPRegressor
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

SEED = 1
BOUND = 20.0  # standard deviations of the output, beyond which a simulation has run away
CHOICE = 0.25  # the share of what is taught with that choices are tried on


class RunAway(Exception):
    """A simulation that grows without bound."""


def rmse(one, other):
    return float(np.sqrt(np.mean((one - other) ** 2)))


def chosen(makers, inputs, output, split):
    """The simulation by the maker that errs least on the last part of what it is taught with; then taught with all."""
    first = int(split * (1 - CHOICE))

    def error(maker):
        try:
            simulated = maker(inputs[:split], output[:first], first)
        except RunAway:
            return np.inf
        return rmse(simulated, output[first:split])

    return min(makers, key=error)(inputs, output[:split], split)


def history(inputs):
    """What a forest sees of the past: the inputs at delays that double, and where the first input has turned last."""
    rows = len(inputs)
    columns = [inputs]
    delay = 1
    while delay < min(rows // 4, 600):
        columns.append(np.vstack([np.repeat(inputs[:1], delay, axis=0), inputs[:-delay]]))
        delay *= 2
    u = inputs[:, 0]
    turns, turn, before, rising = [], u[0], u[0], 0.0
    for k in range(rows):
        step = u[k] - u[k - 1] if k else 0.0
        if step * rising < 0:
            turn, before = u[k - 1], turn
        rising = step if step else rising
        turns.append((turn, before, np.sign(rising)))
    extremes = [np.minimum.accumulate(u), np.maximum.accumulate(u)]
    return np.column_stack([*columns, np.array(turns), *extremes])


def forest(least):
    def simulate(inputs, output, split):
        features = history(inputs)
        trees = RandomForestRegressor(200, min_samples_leaf=least, n_jobs=2, random_state=SEED)
        return trees.fit(features[:split], output).predict(features[split:])

    return simulate


def lagged(inputs, output, k, order):
    """A row of a regression: outputs before k, inputs up to k."""
    return np.concatenate([output[k - order : k], inputs[k - order : k + 1].ravel()])


def neural(order, width, seed):
    """A neural NARX model: the next output from outputs and inputs before it; taught one step ahead."""

    def simulate(inputs, output, split):
        rows = np.array([lagged(inputs, output, k, order) for k in range(order, split)])
        # One step ahead the output itself is nearly right: what it changes by is what is to be learnt.
        change = output[order:] - output[order - 1 : -1]
        size = np.std(change) or 1.0
        net = MLPRegressor(
            hidden_layer_sizes=(width,), activation="tanh", solver="lbfgs", alpha=1e-3, max_iter=400, random_state=seed
        )
        net.fit(rows, change / size)
        whole = np.concatenate([output, np.zeros(len(inputs) - split)])
        layers = list(zip(net.coefs_, net.intercepts_))
        for k in range(split, len(inputs)):
            hidden = np.tanh(lagged(inputs, whole, k, order) @ layers[0][0] + layers[0][1])
            whole[k] = whole[k - 1] + size * (hidden @ layers[1][0] + layers[1][1])[0]
            if not abs(whole[k]) < BOUND:
                raise RunAway
        return whole[split:]

    return simulate


def polynomial(terms, inputs, output, split, weights):
    """Simulates a polynomial NARX model of SysIdentPy.

    A term is a list of codes: 1001 is the output one row before, 2001 the first input, 0 nothing.
    """
    whole = np.concatenate([output[:split], np.zeros(len(inputs) - split)])
    columns = [whole, *inputs.T]
    places = [[(code // 1000 - 1, code % 1000) for code in term if code] for term in terms]
    for k in range(split, len(inputs)):
        value = 0.0
        for weight, term in zip(weights, places):
            for column, lag in term:
                weight *= columns[column][k - lag]
            value += weight
        if not abs(value) < BOUND:
            raise RunAway
        whole[k] = value
    return whole[split:]


def narmax(lags, degree):
    """NARMAX by SysIdentPy: terms by forward regression, then weights refined on the error of the simulation."""

    def simulate(inputs, output, split):
        count = inputs.shape[1]
        model = FROLS(
            order_selection=True,
            n_info_values=15,
            info_criteria="bic",
            ylag=lags,
            xlag=lags if count == 1 else [list(range(1, lags + 1))] * count,
            estimator=LeastSquares(),
            basis_function=Polynomial(degree=degree),
            model_type="NARMAX" if count == 1 else "NARX",
        )
        try:
            model.fit(X=inputs[:split], y=output[:split].reshape(-1, 1))
        except (ValueError, np.linalg.LinAlgError) as error:
            raise RunAway from error
        # Its terms of the noise have no part in a simulation.
        noise = 2000 + 1000 * count
        kept = [i for i, term in enumerate(model.final_model) if all(code < noise for code in term)]
        terms = [list(map(int, model.final_model[i])) for i in kept]
        weights = model.theta.ravel()[kept].astype(float)
        every = max(1, split // 1500)
        start = max(lags, 1)

        def error(weights):
            try:
                simulated = polynomial(terms, inputs[:split], output, start, weights)
            except RunAway:
                return np.full(len(range(start, split, every)), BOUND)
            return (simulated - output[start:split])[::every]

        refined = least_squares(error, weights, x_scale=np.maximum(np.abs(weights), 1e-3), max_nfev=8).x
        return polynomial(terms, inputs, output, split, refined)

    return simulate


def sindy(threshold):
    """Dynamics of what `mgpi identify` leaves, by SINDy; `plain` is what that simulates."""

    def of(plain):
        def simulate(inputs, output, split):
            left = output - plain[:split]
            size = np.std(left) or 1.0
            moves = np.gradient(inputs[:, 0])
            controls = np.column_stack([inputs, moves / (np.std(moves) or 1.0)])
            model = pysindy.DiscreteSINDy(
                optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-3),
                feature_library=pysindy.PolynomialLibrary(degree=2),
            )
            model.fit((left / size).reshape(-1, 1), t=1, u=controls[:split])
            weights = model.coefficients()[0]
            powers = model.feature_library.powers_
            value, values = left[-1] / size, []
            for k in range(split, len(inputs)):
                row = np.concatenate([[value], controls[k - 1]])
                value = float(np.prod(row**powers, axis=1) @ weights)
                if not abs(value) < BOUND:
                    raise RunAway
                values.append(value)
            return plain[split : len(inputs)] + size * np.array(values)

        return simulate

    return of


def main():
    warnings.filterwarnings("ignore")
    given = json.load(sys.stdin)
    inputs, output = np.array(given["inputs"], float).T, np.array(given["output"], float)
    split, plain = given["split"], np.array(given["plain"], float)
    means, sizes = inputs[:split].mean(axis=0), inputs[:split].std(axis=0)
    inputs = (inputs - means) / np.where(sizes > 0, sizes, 1.0)
    mean, size = output.mean(), output.std()
    output, plain = (output - mean) / size, (plain - mean) / size
    families = {
        "NARMAX (SysIdentPy)": [narmax(lags, degree) for lags in (2, 4) for degree in (1, 2)],
        "neural NARX": [neural(order, width, seed) for order in (2, 5) for width in (8, 20) for seed in (1, 2)],
        "forest on input history": [forest(least) for least in (1, 5, 20)],
        "SINDy on the residual": [sindy(threshold)(plain) for threshold in (0.003, 0.03, 0.1)],
    }
    answers = {}
    for name, makers in families.items():
        try:
            answers[name] = (mean + size * chosen(makers, inputs, output, split)).tolist()
        except RunAway:
            answers[name] = None
    json.dump(answers, sys.stdout)


if __name__ == "__main__":
    main()
