"""Residual estimators, run tick by tick."""

import numpy as np
import torch
from pydrake.systems.framework import Context

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.gate import GateCause
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Guards, Model, Residual, Scenario
from aerodrake.systems.residual_estimator import ResidualEstimator

# Threads that wait for each other cost a hundred times the arithmetic.
torch.set_num_threads(1)

JOINTS = 6
DT = 0.02
PORTS = ("state", "x_0", "base_setpoint", "joint_setpoint", "saturated")
OUTPUTS = ("delta", "prediction_error", "nominal_prediction_error")


def equivalent_model(kind: str = "exact") -> EquivalentModel:
    return EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=(1.8, 2.0, 2.4))), JOINTS)


def trained(seed: int = 5) -> ResidualNetwork:
    network = ResidualNetwork.untrained(JOINTS, seed)
    rng = np.random.default_rng(seed)
    with torch.no_grad():
        network.last.weight.copy_(torch.tensor(0.1 * rng.normal(size=(3, 32))))
        network.last.bias.copy_(torch.tensor(0.1 * rng.normal(size=3)))
    return network


def inputs(ticks: int, seed: int = 0, nx: int = 12 + 2 * JOINTS) -> list[dict[str, np.ndarray]]:
    """Returns random values of the input ports at each tick."""
    rng = np.random.default_rng(seed)
    sizes = (VehicleState.size(JOINTS), nx, 9, 3 * JOINTS, 1)
    flight = [
        {port: 0.3 * rng.normal(size=size) for port, size in zip(PORTS, sizes, strict=True)}
        for _ in range(ticks)
    ]
    for tick in flight:
        tick["state"][0] = 1
    return flight


def plain(mode: str, learning_rate: float, batch: int) -> Residual:
    """Returns the paper's printed form: no guards, no gate."""
    return Residual(mode=mode, learning_rate=learning_rate, batch=batch, **Guards()._asdict())


def drive(estimator: ResidualEstimator, context: Context, flight) -> dict[str, np.ndarray]:
    """Runs the estimator tick by tick, from the time of its Context.

    Returns:
        `delta` as sampled at each tick, and the errors after it.
    """
    log = {name: [] for name in OUTPUTS}
    for tick in flight:
        for port, value in tick.items():
            estimator.GetInputPort(port).FixValue(context, value)
        log["delta"].append(estimator.GetOutputPort("delta").Eval(context))
        context.SetDiscreteState(estimator.EvalUniquePeriodicDiscreteUpdate(context))
        for name in OUTPUTS[1:]:
            log[name].append(estimator.GetOutputPort(name).Eval(context))
        context.SetTime(context.get_time() + DT)
    return {name: np.array(values) for name, values in log.items()}


def fly(network, model, mode, learning_rate, batch, flight) -> dict[str, np.ndarray]:
    estimator = ResidualEstimator(network, model, plain(mode, learning_rate, batch))
    return drive(estimator, estimator.CreateDefaultContext(), flight)


def assert_same(log, expected):
    for name in OUTPUTS:
        np.testing.assert_allclose(log[name], expected[name], rtol=0, atol=1e-10, err_msg=name)


def steady(ticks: int) -> list[dict[str, np.ndarray]]:
    """Returns a flight at rest on its setpoint, with a residual that a network can learn."""
    first = inputs(1)[0] | {"saturated": np.zeros(1), "x_0": np.zeros(12 + 2 * JOINTS)}
    velocity = split_state(first["state"]).v_B
    velocity[:] = 0.10, -0.05, 0.02
    first["base_setpoint"] *= 0
    flight = []
    for k in range(ticks):  # The base moves with its velocity.
        state = first["state"].copy()
        split_state(state).p_B[:] = k * DT * velocity
        flight.append(first | {"state": state})
    return flight


def health(estimator: ResidualEstimator, context: Context) -> tuple[GateCause, float]:
    """Returns the cause for which Delta is gated off, and the time since then in s."""
    cause, gated_s = estimator.GetOutputPort("learner_health").Eval(context)
    return GateCause(int(cause)), gated_s
