"""The estimator against a plain loop with autograd, tick by tick."""

import copy
from dataclasses import dataclass, replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from aerodrake.model.equivalent.axis_models import AXIS_MODELS
from aerodrake.model.residual.features import features
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.vehicle.state import split_state
from aerodrake.systems.residual_estimator import ResidualEstimator
from tests.estimator_flights import (
    DT,
    JOINTS,
    OUTPUTS,
    PORTS,
    assert_same,
    drive,
    equivalent_model,
    fly,
    inputs,
    plain,
    trained,
)


@dataclass
class Pending:
    x: np.ndarray
    features: np.ndarray
    delta: np.ndarray


def reference_outputs(network, model, mode, learning_rate, batch, flight):
    """Returns the outputs of the paper's algorithm, with autograd and torch's SGD.

    The loss is the squared error of Delta; in the paper's model this is the printed one.
    """
    network = copy.deepcopy(network)
    sgd = torch.optim.SGD(network.last.parameters(), lr=learning_rate)
    rows, c = model.base_velocity, model.residual_gain
    mode = mode if c.all() else "off"
    pending, window = None, []
    log, error, nominal_error = {name: [] for name in OUTPUTS}, np.zeros(3), np.zeros(3)
    for tick in flight:
        state = split_state(tick["state"])
        u = np.concatenate([tick["base_setpoint"][6:9], tick["joint_setpoint"][12:18]])
        delta, valid = np.zeros(3), all(np.isfinite(value).all() for value in tick.values())
        if valid:
            if pending:
                base = (model.A @ pending.x + model.B @ u)[rows]
                nominal_error = base - state.v_B
                error = model.predict(pending.x, u, pending.delta)[rows] - state.v_B
                if mode == "online":
                    window = [*window, (pending.features, (state.v_B - base) / c)][-batch:]
                    seen, labels = (
                        torch.tensor(np.array(column)) for column in zip(*window, strict=True)
                    )
                    sgd.zero_grad()
                    ((network(seen) - labels) ** 2).sum(dim=1).mean().backward()
                    sgd.step()
            now = features(tick["state"], u)
            if mode != "off":
                delta = network(torch.tensor(now)).detach().numpy()
        log["delta"].append(delta)
        log["prediction_error"].append(error)
        log["nominal_prediction_error"].append(nominal_error)
        pending = None
        if valid:
            pending = Pending(tick["x_0"], now, delta)
    return {name: np.array(values) for name, values in log.items()}


@pytest.mark.parametrize("mode", ["off", "offline", "online"])
@pytest.mark.parametrize("kind", ["flight", *AXIS_MODELS])
def test_outputs_equal_those_of_the_reference_loop(mode, kind):
    model = equivalent_model(kind)
    setup = (trained(), model, mode, 0.01, 20, inputs(45, nx=len(model.A)))
    assert_same(fly(*setup), reference_outputs(*setup))


@pytest.mark.parametrize("batch", [1, 3, 100])
def test_any_batch_size(batch):
    setup = (trained(), equivalent_model(), "online", 0.01, batch, inputs(40))
    assert_same(fly(*setup), reference_outputs(*setup))


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")  # An infinite quaternion.
@pytest.mark.parametrize("port", PORTS)
@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_ticks_with_nan_or_infinite_inputs_are_skipped(port, number):
    flight = inputs(40)
    for k in (0, 7, 8, 30):
        flight[k][port][-1 - k % min(3, len(flight[k][port]))] = number  # In an entry that is used.
    setup = (trained(), equivalent_model(), "online", 0.01, 20, flight)
    log = fly(*setup)
    assert np.all(log["delta"][[0, 7, 8, 30]] == 0)
    assert_same(log, reference_outputs(*setup))


def test_saturated_samples_are_compared_and_not_learned():
    """The flag of the tick that completes a sample counts."""
    setup, flight = (trained(), equivalent_model()), inputs(40)
    saturated = {5, 6, 21}
    for k, tick in enumerate(flight):
        tick["saturated"][:] = k in saturated
    config = replace(plain("online", 0.01, 20), freeze_saturated=True)
    estimator = ResidualEstimator(*setup, config)
    context, errors = estimator.CreateDefaultContext(), []
    for k, tick in enumerate(flight):
        old = estimator.groups.learner.read(context)
        errors.append(drive(estimator, context, [tick])["prediction_error"][0])
        new = estimator.groups.learner.read(context)
        is_learned = k not in saturated and k > 0
        assert new.sample_count == old.sample_count + is_learned
        for name in ("theta", "phis", "targets"):
            assert np.any(getattr(old, name) != getattr(new, name)) == is_learned, name
    assert len(np.unique(errors, axis=0)) == len(errors)

    # Without `freeze_saturated` the flag has no effect.
    assert_same(
        fly(*setup, "online", 0.01, 20, flight),
        reference_outputs(*setup, "online", 0.01, 20, flight),
    )


@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-3, 1.0, 1e3, 1e80]))
@settings(max_examples=25)
def test_delta_is_bounded_at_any_learning_rate(seed, size):
    """c Delta to max_drift |phi| about theta_offline phi."""
    network, model, drift = trained(), equivalent_model(), 0.3
    config = replace(plain("online", 1.0, 5), max_drift=drift)
    estimator = ResidualEstimator(network, model, config)
    context, rng = estimator.CreateDefaultContext(), np.random.default_rng(seed)
    for tick in inputs(25, seed):
        # The label is the measured velocity.
        split_state(tick["state"]).v_B[:] *= size ** rng.uniform()
        delta = drive(estimator, context, [tick])["delta"][0]
        u = np.concatenate([tick["base_setpoint"][6:], tick["joint_setpoint"][2 * JOINTS :]])
        phi = network.phi(features(tick["state"], u))
        away = np.linalg.norm(model.residual_gain * (delta - network.last_layer() @ phi))
        assert away <= drift * np.linalg.norm(phi) * (1 + 1e-9)


def test_off_is_zero_and_predicts_as_the_model_alone():
    log = fly(trained(), equivalent_model(), "off", 0.01, 20, inputs(5))
    assert np.all(log["delta"] == 0)
    np.testing.assert_array_equal(log["prediction_error"], log["nominal_prediction_error"])


@pytest.mark.parametrize("mode", ["offline", "online"])
def test_delta_is_zero_in_the_integral_model(mode):
    assert not fly(trained(), equivalent_model("integral"), mode, 0.01, 20, inputs(30))[
        "delta"
    ].any()


def test_the_first_tick_learns_nothing():
    model = equivalent_model()
    estimator = ResidualEstimator(trained(), model, plain("online", 0.01, 20))
    context = estimator.CreateDefaultContext()
    log = drive(estimator, context, inputs(1))
    theta = estimator.groups.learner.read(context).theta
    np.testing.assert_array_equal(theta, model.residual_gain[:, None] * trained().last_layer())
    assert np.all(log["prediction_error"] == 0) and np.all(log["nominal_prediction_error"] == 0)


def test_the_update_comes_before_the_inference():
    network, model, flight = ResidualNetwork.untrained(JOINTS, 0), equivalent_model(), inputs(2)
    log = fly(network, model, "online", 0.01, 20, flight)

    def phi(tick):
        u = np.concatenate([tick["base_setpoint"][6:], tick["joint_setpoint"][2 * JOINTS :]])
        return network.phi(features(tick["state"], u))

    target = -log["nominal_prediction_error"][1]
    theta = np.outer(0.01 * 2 * target / model.residual_gain, phi(flight[0]))
    assert np.all(log["delta"][0] == 0)
    assert np.all(log["delta"][1] != 0)
    np.testing.assert_allclose(log["delta"][1], theta @ phi(flight[1]), rtol=1e-10)
    # Delta was zero in the prediction that is compared here.
    np.testing.assert_array_equal(log["prediction_error"][1], -target)


def test_clones_are_independent_and_equal():
    estimator = ResidualEstimator(trained(), equivalent_model(), plain("online", 0.01, 20))
    context = estimator.CreateDefaultContext()
    drive(estimator, context, inputs(25))
    estimator.GetOutputPort("delta").Eval(context)  # The cached value is cloned, too.
    clone, other = context.Clone(), context.Clone()
    drive(estimator, other, inputs(30, seed=2))

    continued = drive(estimator, context, inputs(30, seed=1))
    assert_same(drive(estimator, clone, inputs(30, seed=1)), continued)
    for i in range(context.num_discrete_state_groups()):
        np.testing.assert_array_equal(
            context.get_discrete_state(i).value(), clone.get_discrete_state(i).value()
        )


def test_the_network_is_copied():
    network = trained()
    estimator = ResidualEstimator(network, equivalent_model(), plain("offline", 0.01, 20))
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.zero_()
    log = drive(estimator, estimator.CreateDefaultContext(), inputs(3))
    assert_same(log, fly(trained(), equivalent_model(), "offline", 0.01, 20, inputs(3)))


def test_only_delta_has_direct_feedthrough():
    estimator = ResidualEstimator(trained(), equivalent_model(), plain("online", 0.01, 20))
    for port in range(len(PORTS)):
        assert estimator.HasDirectFeedthrough(port, 0)
        assert not estimator.HasDirectFeedthrough(port, 1)
        assert not estimator.HasDirectFeedthrough(port, 2)
        assert not estimator.HasDirectFeedthrough(port, 3)


class Counting(ResidualEstimator):
    ticks = events = 0

    def _calc_tick(self, context, tick):
        self.ticks += 1
        super()._calc_tick(context, tick)

    def _update(self, context, state):
        self.events += 1
        super()._update(context, state)


def test_output_and_update_share_one_computation_that_is_never_stale():
    config = replace(plain("online", 0.01, 20), freeze_saturated=True)
    estimator = Counting(trained(), equivalent_model(), config)
    context = estimator.CreateDefaultContext()
    drive(estimator, context, inputs(30))
    assert estimator.ticks == estimator.events == 30

    delta = estimator.GetOutputPort("delta")
    new = inputs(1, seed=9)[0] | {"saturated": np.ones(1)}
    del new["x_0"]  # It enters the next sample only.
    for port, value in new.items():
        before = delta.Eval(context)
        estimator.GetInputPort(port).FixValue(context, value)
        assert np.any(delta.Eval(context) != before), port
    before = delta.Eval(context)
    theta = estimator.groups.learner.groups["theta"]
    context.SetDiscreteState(theta, context.get_discrete_state(theta).value() + 1)
    assert np.any(delta.Eval(context) != before)


def test_fifty_events_a_second():
    estimator = Counting(trained(), equivalent_model(), plain("online", 0.01, 20))
    simulator = Simulator(estimator)
    context = simulator.get_mutable_context()
    for port, value in inputs(1)[0].items():
        estimator.GetInputPort(port).FixValue(context, value)
    simulator.AdvanceTo(1 - DT / 2)
    assert estimator.events == estimator.ticks == 50
