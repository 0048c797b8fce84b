"""Estimated and true Delta of a flight."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes

from aerodrake.model.equivalent.initial_state import Signals, Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.vehicle.state import split_state
from aerodrake.reports.flight_pictures import residual_picture
from aerodrake.reports.residual_panels import residuals
from aerodrake.scenario import Model

STATE = ("quaternion", "p_B_m", "q_rad", "omega_W_rad_s", "v_B_m_s", "qdot_rad_s")


@pytest.mark.parametrize(
    ("kind", "quantity", "unit"),
    [("flight", "residual acceleration", "mm/s^2"), ("exact", "residual velocity", "mm/s")],
)
def test_the_picture_names_delta_by_the_model(short_flight, monkeypatch, kind, quantity, unit):
    scenario, log = short_flight
    scenario, labels = replace(scenario, model=Model(kind=kind)), []
    monkeypatch.setattr(Axes, "set_ylabel", lambda axes, label: labels.append(label))
    assert f"Delta, the {quantity} of the base" in residual_picture(log, log, scenario).caption
    assert labels[:3] == [f"Delta_{axis} / {unit}" for axis in "xyz"]


def test_the_integral_model_has_no_delta(short_flight):
    scenario, log = short_flight
    _, estimated, true = residuals(log, replace(scenario, model=Model(kind="integral")))
    assert np.isnan(estimated).all() and np.isnan(true).all()


def test_with_the_true_delta_the_model_predicts_the_next_velocity(short_flight):
    scenario, log = short_flight
    times, estimated, true = residuals(log, scenario)
    model = EquivalentModel.of(scenario, log["q_rad"].shape[1])
    assert len(times) > 15 and np.abs(true).max() > 1e-5 and estimated.any()
    # Rows have the values before the updates of their time; filter and MPC are one row late.
    x, starts = None, {}
    for i in range(0, len(log.time_s) - 1, 2):  # At the ticks, from the flight's first.
        state = np.hstack([log[part][i] for part in STATE])
        signals = Signals(
            log["p_B_m"][i],
            log["v_B_m_s"][i],
            np.concatenate([log["p_Bd_m"][i], log["v_Bd_m_s"][i], log["a_Bd_m_s2"][i]]),
            np.concatenate([log["q_d_rad"][i], log["qdot_d_rad_s"][i], log["qddot_d_rad_s2"][i]]),
            Thrust.make(
                split_state(state),
                log["specific_thrust_m_s2"][i],
                log["external_acceleration_m_s2"][i + 1],
                log["disturbance_m_s2"][i],
            ),
        )
        starts[i] = x = model.initial_state(signals, x)
    for time, delta in zip(times, true, strict=True):
        i = int(np.argmin(np.abs(log.time_s - time)))
        u = np.concatenate([log["a_Bd_m_s2"][i + 1], log["qddot_d_rad_s2"][i + 1]])
        predicted = model.predict(starts[i], u, delta)[model.base_velocity]
        np.testing.assert_allclose(predicted, log["v_B_m_s"][i + 2], atol=1e-9)
