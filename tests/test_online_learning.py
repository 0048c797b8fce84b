"""Online learning in flight: its guards in the closed loop, and its printed form."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.features import features
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.scenario import Clover, MovingTarget, Residual, Rotor, Scenario, Sensors, Vehicle
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context


@pytest.mark.parametrize("max_drift", [0.005, 0.01])
def test_delta_is_bounded_at_a_learning_rate_of_one(vehicle, max_drift):
    """c |Delta| to max_drift |phi|, since the offline layer is zero; it exceeds half the bound."""
    scenario = Scenario(
        duration=1.0,
        settle_s=0.0,
        reference=Clover(start_s=0.5),
        sensors=Sensors(velocity_noise_m_s=0.01),
        residual=Residual(mode="online", learning_rate=1.0, max_drift=max_drift, gate_s=0.0),
    )
    log = FlightSimulation(scenario).fly()
    assert log.exit_reason == "completed"
    network = ResidualNetwork.untrained(vehicle.joints, scenario.seed)
    measured = ("quaternion", "p_B_m", "q_rad", "omega_W_rad_s", "v_B_m_s", "qdot_rad_s")
    states = np.hstack([log[f"measured_{part}"] for part in measured])
    u = np.hstack([log["a_Bd_m_s2"], log["qddot_d_rad_s2"]])
    c = EquivalentModel.of(scenario, vehicle.joints).residual_gain
    ratios = []
    for k in range(0, len(states) - 1, 2):  # At the ticks; Delta is logged one row later.
        phi = network.phi(features(states[k], u[k]))
        correction = np.linalg.norm(c * log["delta_m_s2"][k + 1])
        ratios.append(correction / (max_drift * np.linalg.norm(phi)))
    assert 0.5 < max(ratios) <= 1 + 1e-9


def test_as_printed_flies_as_without_each_guard():
    """Bit for bit, although the learning rate makes the guards act."""
    keys = {"duration": 1.5, "settle_s": 0.5, "residual.learning_rate": 0.02}

    def fly(**residual):
        changes = keys | {f"residual.{key}": value for key, value in residual.items()}
        return FlightSimulation(load_scenario("clover_paper", changes)).fly()

    printed, guarded = fly(as_printed=True), fly()
    without = fly(
        max_step=0, max_drift=0, max_error_m_s=0, freeze_saturated=False, gate_s=0, max_offset_m_s=0
    )
    assert np.abs(printed["delta_m_s"]).max() > 2 * np.abs(guarded["delta_m_s"]).max()
    for key in ("p_E_m", "delta_m_s", "prediction_error_m_s"):
        np.testing.assert_array_equal(printed[key], without[key])


def test_nothing_is_learned_while_the_flight_controller_is_saturated():
    """It saturates on the way to a far target: each tick is flagged, or learns a sample."""
    scenario = Scenario(
        settle_s=0.0,
        reference=MovingTarget(),
        vehicle=Vehicle(rotor=Rotor(max_thrust_n=10.0)),  # It hovers with 9.7 N at most.
        residual=Residual(mode="online", max_error_m_s=0.0),
    )
    closed_loop = make_closed_loop(scenario)
    context = make_context(closed_loop, scenario.seed)
    simulator = Simulator(closed_loop, context)
    coordinator = closed_loop.GetSubsystemByName("coordinator")
    estimator = coordinator.GetSubsystemByName("residual_estimator")
    inner = estimator.GetMyContextFromRoot(context)
    count, flagged = 0, 0
    for tick in range(1, 15):
        before = tick * scenario.rates.mpc_period_s
        simulator.AdvanceTo(before - 1e-4)
        saturated = closed_loop.GetOutputPort("saturated").Eval(context)[0]
        simulator.AdvanceTo(before + 1e-4)
        learned = estimator.groups.learner.read(inner).sample_count
        assert learned == count + (saturated == 0)
        count, flagged = learned, flagged + saturated
    assert 0 < flagged < 14
