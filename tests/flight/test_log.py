"""Tests of the log: names, widths, units, and the file."""

import re

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator

from aerodrake.flight.log import DELTA, DERIVED, PORTS, ROWS_PER_WRITE, FlightLog, key_columns
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.supervision.conditions import conditions
from aerodrake.scenario import (
    Accelerometer,
    FixedAxis,
    Hover,
    Model,
    Mpc,
    Scenario,
    Sensors,
    Supervisor,
    ToolSensor,
)
from aerodrake.station import make_closed_loop, make_context
from aerodrake.support.threads import single_thread

KEYS = ["delta_m_s2" if key == DELTA else key for parts in PORTS.values() for key, _ in parts]
"""Keys in the flight model."""

OF_SENSORS = {"measured_specific_force_m_s2", "specific_force_stamp_s", "measured_p_E_m",
              "tool_stamp_s"}  # fmt: skip
"""Keys of flights with accelerometer and tool sensor alone."""

SENSORS = Sensors(accelerometer=Accelerometer(period_s=0.01), tool=ToolSensor(period_s=0.02))

DIMENSIONLESS = {"estimated_quaternion", 
    "quaternion", "measured_quaternion", "gamma", "mode", "w_q", "w_m", "w_d",
    "qp_status", "qp_iterations", "saturated", "tool_axis", "tool_axis_d",
    "supervisor_mode", "supervisor_cause", "conditions", "sample_verdict",
    "rotor_effectiveness", "reference_verdict", "learner_cause", "delta_source",
    "stable_learning_rate", "torque_at_limit",
}  # fmt: skip


@pytest.mark.parametrize("horizon", [3, 15])
def test_parts_cover_their_ports_exactly(vehicle, horizon):
    scenario = Scenario(mpc=Mpc(horizon=horizon), orientation=FixedAxis(), sensors=SENSORS)
    closed_loop = make_closed_loop(scenario)
    beside = {"segment": 1}  # Its time, which is not logged.
    sizes = {"1": 1, "3": 3, "4": 4, "n": vehicle.joints, "k": len(vehicle.rotors.names),
             "3(N+1)": 3 * (horizon + 1), "c": len(conditions(Supervisor()))}  # fmt: skip
    ports = {port: closed_loop.GetOutputPort(port).size() for port in PORTS}
    for port, parts in PORTS.items():
        assert sum(sizes[width] for _, width in parts) + beside.get(port, 0) == ports[port], port
    columns, row = key_columns(ports, "delta_m_s2"), np.arange(sum(ports.values()))
    assert list(columns) == KEYS
    widths = [width for parts in PORTS.values() for _, width in parts]
    for key, width in zip(KEYS, widths, strict=True):
        assert np.shape(row[columns[key]]) == (() if width == "1" else (sizes[width],)), key
    seen = np.hstack([row[part] for part in columns.values()])
    assert len(seen) == len(row) - 1 and list(seen) == sorted(set(seen))


def test_every_vector_of_the_closed_loop_is_logged(vehicle):
    closed_loop = make_closed_loop(Scenario(orientation=FixedAxis(), sensors=SENSORS))
    ports = {
        port.get_name()
        for port in map(closed_loop.get_output_port, range(closed_loop.num_output_ports()))
        if port.size()
    }
    # The segments contain the setpoints and u; plan and horizons are as large as all other signals
    # together, and the next ticks show them. The wind's force shows its velocity.
    not_logged = {"u", "plan", "horizon", "tool_axis_horizon", "base_setpoint", "joint_setpoint"}
    not_logged |= {"wind_velocity"}
    assert ports == {*PORTS, *not_logged}


def test_names_are_unique():
    assert len(KEYS) == len(set(KEYS))
    assert not set(KEYS) & set(DERIVED)


@pytest.mark.parametrize("key", [*KEYS, *DERIVED])
def test_names_end_in_units(key):
    assert key in DIMENSIONLESS or re.search(r"_(s|ms|ticks|m|n|rad|m_s2?|rad_s2?|n_m)$", key)


def test_a_flight_has_all_of_them_and_no_other(short_flight):
    _, log = short_flight
    assert set(log.signals) == {*KEYS, *DERIVED} - OF_SENSORS
    assert [key for key in log.signals if key.endswith("_ms")] == ["tick_ms"]


@pytest.mark.parametrize("kind", ["paper", "exact", "velocity_aware", "integral"])
def test_delta_is_a_velocity_in_the_models_with_k_b_alone(kind):
    log = FlightSimulation(
        Scenario(duration=0.05, settle_s=0.0, model=Model(kind=kind), reference=Hover())
    ).fly()
    assert set(log.signals) == {*KEYS, *DERIVED, "delta_m_s"} - {"delta_m_s2", *OF_SENSORS}
    assert log["delta_m_s"].shape == (len(log.time_s), 3)


def test_parts_are_where_they_belong(short_flight, vehicle):
    """In a flight that begins in trim."""
    _, log = short_flight
    np.testing.assert_allclose(log["quaternion"][0], [1, 0, 0, 0])
    np.testing.assert_allclose(log["p_B_m"][0], vehicle.p_B)
    np.testing.assert_allclose(log["q_rad"][0], vehicle.working)
    np.testing.assert_allclose(log["p_E_m"][0], [0, 0.2, 1.2], atol=1e-6)
    np.testing.assert_allclose(log["p_Bd_m"][0], vehicle.p_B)
    np.testing.assert_allclose(log["q_d_rad"][0], vehicle.working)
    np.testing.assert_allclose(log["joint_torque_n_m"][0], vehicle.trim_torque)
    assert log["thrust_n"][0].sum() == pytest.approx(vehicle.mass * 9.81)
    assert log["v_Ed_m_s"].any() and not log["v_Ed_m_s"][:11].any()
    # Velocities are the derivatives of the positions of the same name.
    for position, velocity in (("p_B_m", "v_B_m_s"), ("q_rad", "qdot_rad_s"),
                               ("p_Bd_m", "v_Bd_m_s"), ("p_Ed_m", "v_Ed_m_s")):  # fmt: skip
        slope = np.gradient(log[position], log.time_s, axis=0)
        np.testing.assert_allclose(slope[2:-2], log[velocity][2:-2], atol=2e-2, err_msg=velocity)


def test_errors_are_distances(vehicle):
    signals = {
        "time_s": np.array([0.0, 1.0]),
        "p_E_m": np.array([[3.0, 4.0, 1.0], [1.0, 2.0, 2.0]]),
        "p_Ed_m": np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]),
        "p_B_m": np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]),
        "p_Bd_m": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
    }
    log = FlightLog(signals, "completed", "", 1.0, vehicle)
    assert list(log.error_m) == [5, 3] and list(log.base_error_m) == [0, 2]
    assert log.time_s is signals["time_s"]


def test_the_tools_angle(vehicle):
    """Small angles are accurate; without the task there is no angle."""
    down = np.array([0.0, 0.0, -1.0])
    desired = np.array([np.sin(t) * np.eye(3)[0] + np.cos(t) * down for t in (0, 1e-9, 1, 3)])
    signals = {"tool_axis": np.tile(down, (4, 1)), "tool_axis_d": desired}
    log = FlightLog(signals, "completed", "", 1.0, vehicle)
    np.testing.assert_allclose(log.tool_angle_rad, [0, 1e-9, 1, 3], rtol=1e-9)
    off = FlightLog(signals | {"tool_axis_d": 0 * desired}, "completed", "", 1.0, vehicle)
    assert off.tool_angle_rad is None


def test_saved_and_read_without_pickle(short_flight, tmp_path):
    _, log = short_flight
    log.save(tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz", allow_pickle=False) as read:
        assert list(read) == list(log.signals)
        for key in read:
            assert read[key].dtype == log[key].dtype
            np.testing.assert_array_equal(read[key], log[key])


def test_a_thinned_log_reads_the_file_once(short_flight, tmp_path):
    _, log = short_flight
    log.save(tmp_path / "log.npz")
    how = {"exit_reason": "completed", "exit_cause": "", "wall_s": 1.0}
    for most in (10, 1000):
        thin = FlightLog.read(tmp_path / "log.npz", how, log.vehicle).thinned(most)
        assert thin["p_E_m"] is thin["p_E_m"]
        np.testing.assert_array_equal(thin["p_E_m"], log.thinned(most)["p_E_m"])
        assert list(thin.signals) == list(log.signals)


@pytest.mark.parametrize("samples", [0, 1, ROWS_PER_WRITE, 2 * ROWS_PER_WRITE + 1])
def test_saved_piece_by_piece(vehicle, samples, tmp_path):
    """Arrays of any memory layout."""
    rows = np.random.default_rng(0).normal(size=(samples, 3))
    signals = {
        "c": rows,
        "fortran": np.asfortranarray(rows),
        "part": rows[:, 1:],
        "one": rows[:, 0],
    }
    FlightLog(signals, "completed", "", 1.0, vehicle).save(tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz", allow_pickle=False) as read:
        for key, expected in signals.items():
            np.testing.assert_array_equal(read[key], expected)


def test_the_end_effector_in_the_base_frame(vehicle):
    """R_B' (p_E - p_B), with Drake's rotation; not finite where the state is not."""
    rng = np.random.default_rng(0)
    quaternions = rng.normal(size=(5, 4))
    r, p_B = rng.normal(size=(2, 5, 3))
    signals = {"quaternion": quaternions, "p_B_m": p_B, "p_E_m": p_B + r}
    expected = [
        RotationMatrix(Quaternion(q / np.linalg.norm(q))).matrix().T @ v
        for q, v in zip(quaternions, r, strict=True)
    ]
    log = FlightLog(signals, "completed", "", 1.0, vehicle)
    np.testing.assert_allclose(log.p_EB_m, expected, atol=1e-14)
    quaternions[2] = np.nan
    assert np.isnan(log.p_EB_m[2]).all() and np.isfinite(log.p_EB_m[3]).all()


def test_read_is_the_reverse_of_save(short_flight, tmp_path):
    _, log = short_flight
    log.save(tmp_path / "log.npz")
    summary = {"exit_reason": "lost", "exit_cause": "tilt", "wall_s": 2.0}
    again = FlightLog.read(tmp_path / "log.npz", summary, log.vehicle)
    assert (again.exit_reason, again.exit_cause, again.wall_s) == ("lost", "tilt", 2.0)
    assert list(again.signals) == list(log.signals)
    for key, rows in log.signals.items():
        np.testing.assert_array_equal(again[key], rows)


@pytest.mark.parametrize("most", [7, 60, 61, 1000])
def test_thinned_for_figures(short_flight, most):
    """Evenly, up to the last sample; signals of ticks stay whole."""
    _, log = short_flight
    thin = log.thinned(most)
    assert most / 2 < len(thin.time_s) <= most or len(thin.time_s) == 61 <= most
    steps = np.diff(thin.time_s)
    np.testing.assert_allclose(steps, steps[0])
    assert thin.time_s[-1] == log.time_s[-1]
    assert list(thin.signals) == list(log.signals) and len(thin.signals) == len(log.signals)
    rows = np.searchsorted(log.time_s, thin.time_s)
    for key, signal in thin.signals.items():
        expected = log[key] if key == "tick_ms" else log[key][rows]
        np.testing.assert_array_equal(signal, expected, err_msg=key)


def test_setpoints_are_those_of_their_ports(short_flight):
    """Between ticks, too, though the ports are not evaluated for the log."""
    scenario, log = short_flight
    closed_loop = make_closed_loop(scenario)
    context = make_context(closed_loop, scenario.seed)
    simulator = Simulator(closed_loop, context)
    keys = {"base_setpoint": ("p_Bd_m", "v_Bd_m_s", "a_Bd_m_s2"),
            "joint_setpoint": ("q_d_rad", "qdot_d_rad_s", "qddot_d_rad_s2")}  # fmt: skip
    with single_thread():
        for row in (13, 14, 15, 16):
            simulator.AdvanceTo(round(0.01 * row, 9))  # Updates of this instant are still to come.
            for port, parts in keys.items():
                expected = closed_loop.GetOutputPort(port).Eval(context)
                np.testing.assert_array_equal(
                    np.concatenate([log[key][row] for key in parts]), expected
                )
