"""python-control simulates a model as we do."""

import numpy as np
import pytest

control = pytest.importorskip("control")
mgpi = pytest.importorskip("mgpi")
import mgpi.control  # noqa: E402


@pytest.fixture(scope="module")
def recording(recordings):
    return mgpi.Recording(recordings / "rig-fig8.csv")


@pytest.mark.parametrize("options", [{}, {"model": "agpi", "plays": 5}, {"plays": 40, "dead_zones": 1}])
def test_its_answer_is_that_of_the_model(recording, options):
    model = mgpi.Identifier(starts=2, **options).fit(recording).model_
    random = np.random.default_rng(3)
    low, high = model.input_range
    walk = np.clip(low + np.abs(np.cumsum(random.normal(0.0, 0.4, 2000))), low, high)
    decaying = low + 0.5 * (high - low) * (1.0 + np.sin(np.arange(500)) * np.exp(-0.01 * np.arange(500)))
    for inputs in (walk, decaying, np.repeat(walk[:200], 3)):
        times = 0.01 * np.arange(len(inputs))
        answer = control.input_output_response(mgpi.control.system(model, dt=0.01, memory=500), times, inputs).outputs
        ours = model.simulate(inputs)
        stroke = model.output_range[1] - model.output_range[0]
        print(options, np.abs(answer - ours).max() / stroke, "of the stroke")
        # What is wiped out leaves its roundings: in sums over many plays, and where there are two envelopes.
        assert np.abs(answer - ours).max() <= (1e-13 if options else 0.0) * stroke


def test_in_a_loop_with_an_integrator_it_comes_to_the_set_point(recording):
    model = mgpi.Identifier(starts=2).fit(recording).model_
    muscle = mgpi.control.system(model, dt=0.01)
    low, high = model.input_range
    controller = control.NonlinearIOSystem(
        lambda t, x, u, p: np.clip(x + 0.02 * u, low, high),
        lambda t, x, u, p: x,
        inputs=["error_mm"],
        outputs=[model.input_name],
        states=["sum"],
        dt=0.01,
        name="controller",
    )
    difference = control.summing_junction(["wanted_mm", f"-{model.output_name}"], "error_mm")
    loop = control.interconnect(
        [muscle, controller, difference], inputs=["wanted_mm"], outputs=[model.output_name], dt=0.01
    )
    times = 0.01 * np.arange(3000)
    wanted = np.where(times < 15.0, 10.0, 5.0)
    answer = control.input_output_response(loop, times, wanted).outputs
    assert abs(answer[1499] - 10.0) < 0.01 and abs(answer[-1] - 5.0) < 0.01


def test_what_it_cannot_be_is_refused(recording, recordings):
    model = mgpi.Identifier(starts=2).fit(recording).model_
    late = mgpi.Model.from_toml(model.to_toml() + "\n[extensions.transport_delay]\ndelay_s = 0.02\n")
    with pytest.raises(mgpi.ModelError, match="transport_delay"):
        mgpi.control.system(late)
    times = 0.01 * np.arange(100)
    swings = 3.0 + 2.0 * np.sin(3.0 * np.arange(100)) * 0.97 ** np.arange(100)
    with pytest.raises(mgpi.ModelError, match="memory=4"):
        control.input_output_response(mgpi.control.system(model, memory=4, dt=0.01), times, swings)
