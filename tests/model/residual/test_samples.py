"""Samples of recorded flights, against the estimator in a diagram and the model itself."""

import numpy as np
import pytest
import torch
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.model.equivalent.axis_models import AXIS_MODELS
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.online_learner import OnlineLearner
from aerodrake.model.residual.samples import Excitation, residual_samples
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Model, Residual, Scenario
from aerodrake.systems.equivalent_state import EquivalentState
from aerodrake.systems.residual_estimator import ResidualEstimator

JOINTS, DT = 6, 0.02


def equivalent_model(kind: str = "exact") -> EquivalentModel:
    return EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=(1.8, 2.0, 2.4))), JOINTS)


def recorded(ticks: int, seed: int = 0) -> Excitation:
    """Returns a flight with random values at each tick."""
    rng = np.random.default_rng(seed)
    sizes = (VehicleState.size(JOINTS), 9, 3 * JOINTS, 1, 3, 6)
    state, base, joints, thrust, external, disturbance = (
        0.3 * rng.normal(size=(ticks, size)) for size in sizes
    )
    state[:, 0] = 1
    return Excitation(DT * np.arange(ticks), state, thrust, external, disturbance, base, joints)


def before_the_tick(setpoint: np.ndarray, order: int) -> np.ndarray:
    """Returns the setpoints that the integrator outputs at a tick, with the last acceleration."""
    shifted = setpoint.copy()
    shifted[1:, 2 * order :] = setpoint[:-1, 2 * order :]
    return shifted


@pytest.mark.parametrize("kind", ["flight", *AXIS_MODELS])
def test_samples_and_learning_equal_those_of_the_estimator_in_a_diagram(kind):
    """The targets are the negative nominal errors."""
    ticks, model, network = 60, equivalent_model(kind), ResidualNetwork.untrained(JOINTS, 3)
    with torch.no_grad():
        network.last.weight.fill_(0.1)
    config = Residual(mode="online", learning_rate=0.05, batch=7, max_step=0.05, max_drift=0.3,
                      max_error_m_s=1.0, gate_s=0.0)  # fmt: skip
    flight = recorded(ticks)
    saturated = np.random.default_rng(9).uniform(size=ticks) < 0.2
    saturated[1] = True  # The recorded flight lacks the first sample.
    builder = DiagramBuilder()
    estimator = builder.AddSystem(ResidualEstimator(network, model, config))
    equivalent_state = builder.AddSystem(EquivalentState(model))
    builder.Connect(equivalent_state.GetOutputPort("x_0"), estimator.GetInputPort("x_0"))
    both = (estimator, equivalent_state)
    for port, rows, readers in (
        ("state", flight.state, both),
        ("base_setpoint", before_the_tick(flight.base_setpoint, 3), both),
        ("joint_setpoint", before_the_tick(flight.joint_setpoint, JOINTS), both),
        ("specific_thrust", flight.specific_thrust, [equivalent_state]),
        ("external_acceleration", flight.external_acceleration, [equivalent_state]),
        ("disturbance", flight.disturbance, [equivalent_state]),
        ("saturated", saturated[:, None].astype(float), [estimator]),
    ):
        # A tick falls in the middle of its row's interval.
        signal = PiecewisePolynomial.ZeroOrderHold(
            DT * (np.arange(ticks + 1) - 0.5), np.vstack([rows, rows[-1]]).T
        )
        source = builder.AddSystem(TrajectorySource(signal))
        for reader in readers:
            builder.Connect(source.get_output_port(), reader.GetInputPort(port))
    nominal_error = estimator.GetOutputPort("nominal_prediction_error")
    errors = LogVectorOutput(nominal_error, builder, DT)
    deltas = LogVectorOutput(estimator.GetOutputPort("delta"), builder, DT)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo(DT * (ticks - 0.5))

    features, targets = residual_samples(model, flight)
    assert features.shape == (ticks - 2, 12 + 3 * JOINTS) and targets.shape == (ticks - 2, 3)
    # The error of the sample that began at k is known after the tick k+1: logged at k+2.
    error = errors.FindLog(simulator.get_context()).data().T
    np.testing.assert_array_equal(-error[3:], targets[:-1])
    context = estimator.GetMyContextFromRoot(simulator.get_context())
    np.testing.assert_array_equal(-nominal_error.Eval(context), targets[-1])

    gain = model.residual_gain
    learner = OnlineLearner(config, gain[:, None] * network.last_layer())
    phi = np.array(
        [network.phi(row) for row in features]
    )  # One call for all rows rounds differently.
    delta = deltas.FindLog(simulator.get_context()).data().T
    if kind == "integral":
        assert not delta.any()
        return
    correction = learner.run(phi, targets, saturated[2:])
    np.testing.assert_array_equal(delta[1:-1], correction / gain)
    assert not np.array_equal(correction[-1], learner.theta_offline @ phi[-1])


def test_features_are_the_state_now_and_the_input_before():
    flight = recorded(9)
    features, _ = residual_samples(equivalent_model(), flight)
    now = [split_state(x) for x in flight.state[1:-1]]
    np.testing.assert_array_equal(features[:, 3:6], [x.v_B for x in now])
    np.testing.assert_array_equal(features[:, 9:15], [x.q for x in now])
    np.testing.assert_array_equal(features[:, 21:24], flight.base_setpoint[:-2, 6:])
    np.testing.assert_array_equal(features[:, 24:], flight.joint_setpoint[:-2, 2 * JOINTS :])


@pytest.mark.parametrize("kind", [kind for kind in AXIS_MODELS if kind != "integral"])
def test_targets_of_the_model_with_a_known_residual(kind):
    """Under constant accelerations over each period, the target is c Delta."""
    ticks, model, rng = 40, equivalent_model(kind), np.random.default_rng(1)
    delta = np.array([0.1, -0.05, 0.02])
    u = rng.normal(size=(ticks, 3 + JOINTS))
    x = 0.1 * rng.normal(size=len(model.A))
    flight = recorded(ticks)
    for k in range(ticks):
        measured = split_state(flight.state[k])
        measured.p_B[:], measured.v_B[:] = x[model.base_position], x[model.base_velocity]
        flight.base_setpoint[k] = np.concatenate(
            [x[model.setpoint_position], x[model.setpoint_velocity], u[k, :3]]
        )
        flight.joint_setpoint[k] = np.concatenate(
            [x[model.joint_position], x[model.joint_velocity], u[k, 3:]]
        )
        x = model.predict(x, u[k], delta)
    _, targets = residual_samples(model, flight)
    expected = model.C[model.base_velocity] @ delta
    np.testing.assert_allclose(targets, np.tile(expected, (ticks - 2, 1)), rtol=0, atol=1e-12)
