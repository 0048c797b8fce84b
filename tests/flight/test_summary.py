"""The summary of made-up logs: modes, ticks, residual, arm and supervisor."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.summary import headline, millimetres, summarize, to_json
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.supervision.conditions import conditions
from aerodrake.scenario import Rates, Residual, Scenario, Supervisor
from tests.logs import CLOVER, figures, made


def test_the_tools_angle_over_reference_time():
    """90 deg in the hover before, 0.1 rad until 15 s, 0.2 rad after."""
    angle = lambda t: np.select([t < 0, t < 15 - 1e-9], [np.pi / 2, 0.1], 0.2)  # noqa: E731
    log = made()
    desired = np.stack(
        [np.sin(angle(log.time_s)), 0 * log.time_s, -np.cos(angle(log.time_s))], axis=1
    )
    figures = summarize(Scenario(), made(tool_axis_d=desired))["orientation"]
    assert figures["max_rad"] == pytest.approx(0.2)
    assert figures["settled_mean_rad"] == pytest.approx(0.2)
    assert figures["mean_rad"] == pytest.approx((1500 * 0.1 + 1501 * 0.2) / 3001)
    assert figures["rms_rad"] == pytest.approx(np.sqrt((1500 * 0.01 + 1501 * 0.04) / 3001))
    assert set(summarize(Scenario(), log)["orientation"].values()) == {None}


def test_seconds_in_each_mode_add_up_to_reference_time():
    edges = [0.0, 1.23, 4.0, 4.01]

    def mode(t):
        index = np.searchsorted(edges, t + 1e-9, side="right")
        return np.array([Mode.ADJUSTMENT, *Mode])[index].astype(float)

    modes = figures(made(mode=mode, until_s=10))["modes"]
    assert list(modes) == ["flight", "coordinated", "hover", "adjustment"]
    expected = [1.23, 2.77, 0.01, 5.99]
    assert list(modes.values()) == pytest.approx(expected, abs=1e-9)
    assert sum(modes.values()) == pytest.approx(10, abs=1e-9)


def test_no_mode_before_reference_time():
    assert sum(figures(made(until_s=-0.5))["modes"].values()) == 0


def test_ticks():
    tick_ms = np.ones(1550)
    tick_ms[:31] = [*range(20, 51)]
    mpc = figures(made(tick_ms=tick_ms))["mpc"]
    assert mpc["ticks"] == 1550 and mpc["missed"] == 0
    assert mpc["median_ms"] == 1.0
    assert mpc["p99_ms"] == pytest.approx(np.quantile(tick_ms, 0.99))
    assert mpc["overruns"] == 30  # 20 ms is in time.


def test_overruns_are_over_the_scenarios_period():
    scenario = Scenario(reference=CLOVER.reference, settle_s=1, rates=Rates(mpc_period_s=0.05))
    mpc = figures(made(tick_ms=np.array([49.0, 50.0, 51.0])), scenario)["mpc"]
    assert mpc["overruns"] == 1


def test_no_ticks():
    mpc = figures(made(tick_ms=np.array([])))["mpc"]
    assert mpc["ticks"] == mpc["overruns"] == 0
    assert mpc["median_ms"] is mpc["p99_ms"] is None


def test_each_ticks_status_counts_once():
    """The port shows a tick's status from its next sample on, for one period."""
    log = made(until_s=1.0)
    status = log.signals["qp_status"]
    per_tick = np.zeros(100)
    per_tick[[0, 7, 99]] = QpStatus.ITERATION_LIMIT
    per_tick[[3, 4]] = QpStatus.SOLVED
    per_tick[50], per_tick[60] = QpStatus.INACCURATE, QpStatus.RELAXED
    status[1:] = np.repeat(per_tick, 2)
    mpc = figures(log)["mpc"]
    assert mpc["solver_fallbacks"] == 3
    assert mpc["solver"] == "osqp"
    assert mpc["solved_by"] == {
        "unconstrained": 93,
        "osqp": 3,
        "softened": 0,
        "relaxed": 1,
        "none": 3,
    }
    assert sum(mpc["solved_by"].values()) == mpc["ticks"]


def test_residual_is_measured_with_and_without_the_network():
    """Vectors (3, 4, 0) and (0, 0, 0) half of the time each: the RMS of their lengths."""
    errors = np.zeros((3101, 3))
    errors[100:] = np.where(np.arange(3001)[:, None] % 2 == 0, [3.0, 4.0, 0.0], 0.0)
    errors[:100] = 1e6  # In the initial hover.
    log = made(prediction_error_m_s=errors, nominal_prediction_error_m_s=2 * errors)
    rmse = figures(log)["residual"]["prediction_rmse_m_s"]
    assert rmse["with_network"] == pytest.approx(5 * math.sqrt(1501 / 3001))
    assert rmse["without_network"] == pytest.approx(2 * rmse["with_network"])


def test_the_time_with_each_delta_and_the_stable_learning_rate():
    """In the hover before, the offline layer; then the learned one, from 20 s on none."""
    time_s = made().time_s
    source = np.select([time_s < 0, time_s < 20 - 1e-9], [1.0, 0.0], 2.0)
    bound = np.where(time_s < -0.5, 0.0, 0.002 + 0.001 * (time_s > 3))
    log = made(delta_source=source, stable_learning_rate=bound)
    for mode in ("offline", "online"):
        config = Residual(mode=mode, learning_rate=0.0012)
        figures = summarize(replace(CLOVER, residual=config), log)["residual"]
        assert figures["source_s"] == {"learned": 20.0, "offline": 0.0, "none": 10.0}
        rates = figures["learning_rate"], figures["stable_learning_rate"]
        assert rates == ((0.0012, 0.002) if mode == "online" else (None, None))
    early = made(delta_source=source, stable_learning_rate=0 * bound)
    figures = summarize(replace(CLOVER, residual=Residual(mode="online")), early)["residual"]
    assert figures["learning_rate"] is None and figures["stable_learning_rate"] is None


def test_facts_of_the_flight():
    facts = figures(made(exit_reason="lost", exit_cause="tilt of 61 deg", wall_s=6.2))
    assert facts["scenario"] == "made" and facts["seed"] == 5
    assert facts["simulated_s"] == 31 and facts["wall_s"] == 6.2
    assert facts["real_time_factor"] == 5
    assert (facts["exit_reason"], facts["exit_cause"]) == ("lost", "tilt of 61 deg")
    assert facts["residual"]["mode"] == "off"


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_json_is_strict_with_nan_and_infinity(number):
    log = made(error=lambda t: np.where(t < 20, 0.001, number))
    log.signals["prediction_error_m_s"][-1] = number
    text = to_json(summarize(CLOVER, log))

    def refuse(constant):
        raise AssertionError(constant)

    error = json.loads(text, parse_constant=refuse)["error"]
    assert error["mean_m"] is error["max_m"] is None
    assert text.endswith("}\n")


def test_workspace_use_of_the_arm(vehicle):
    """1.2 s at 0.1 m from the centre of the learning space, 0.01 s at 0.2 m; a joint near a limit.

    The initial hover and the last sample do not count.
    """
    log = made(until_s=5.0)
    offset = np.select([log.time_s < 0, log.time_s < 1.2 - 1e-9], [0.3, 0.1], 0.0)
    offset[log.time_s == 3.0] = 0.2
    p_E = log["p_B_m"] + vehicle.p_O + np.outer(offset, [0.0, 0.6, 0.8])
    q = log["q_rad"].copy()
    q[log.time_s < 0, 2] = vehicle.upper[2]
    q[log.time_s == 2.0, 2] = vehicle.upper[2] - 0.02
    arm = figures(made(until_s=5.0, p_E_m=p_E, q_rad=q))["arm"]
    assert arm["farthest_d_o_m"] == pytest.approx(0.2)
    assert arm["outside_s"] == pytest.approx(1.21)
    assert arm["least_room_rad"] == pytest.approx(0.02)
    q[log.time_s == 2.0, 2] = vehicle.upper[2] + 0.01
    assert figures(made(until_s=5.0, q_rad=q))["arm"]["least_room_rad"] == pytest.approx(-0.01)


def test_share_of_time_with_torque_at_its_limit():
    """From reference time 0 on, by joint."""
    log = made(until_s=5.0)
    at_limit = np.zeros_like(log["q_rad"])
    at_limit[log.time_s < 0, 0] = 1
    at_limit[(log.time_s >= 1) & (log.time_s < 3), 2] = 1
    shares = figures(made(until_s=5.0, torque_at_limit=at_limit))["arm"]["torque_at_limit"]
    assert list(shares) == list(log.vehicle.joint_names)
    assert shares.pop("elbow_pitch") == pytest.approx(0.4, rel=1e-2)
    assert not any(shares.values())


def test_modes_and_events_of_the_supervisor():
    t = made().time_s
    names = [condition.name for condition in conditions(Supervisor())]
    active = np.zeros((len(t), len(names)))
    in_hold = (t > 2 - 1e-9) & (t < 5 - 1e-9)
    active[in_hold, names.index("plan_outage")] = 1
    log = made(conditions=active, supervisor_mode=in_hold.astype(float))
    figures = summarize(Scenario(), log)
    assert figures["safe_modes"] == {"nominal": 28.0, "hold": 3.0, "descend": 0.0, "stop": 0.0}
    assert [(e["time_s"], e["cause"], e["event"]) for e in figures["events"]] == [
        (2.0, "plan_outage", "triggered"),
        (5.0, "plan_outage", "cleared"),
    ]


def test_flights_are_compared_by_the_first_figure_that_any_has():
    none = {"lap_mean_m": None, "settled_mean_m": None, "mean_m": None}
    failed = {"exit_reason": "failed", "exit_cause": "MemoryError"}
    flights = {"lost": {"error": none}, "failed": failed}
    assert headline(flights) == "mean_m"
    flights["short"] = {"error": none | {"mean_m": 0.1}}
    assert headline(flights) == "mean_m"
    flights["settled"] = {"error": none | {"mean_m": 0.1, "settled_mean_m": 0.1}}
    assert headline(flights) == "settled_mean_m"
    flights["lap"] = {"error": none | {"lap_mean_m": 0.1}}
    assert headline(flights) == "lap_mean_m"


def test_millimetres_have_two_digits_and_three_below_1_mm():
    assert millimetres(0.0122) == "12.20"
    assert millimetres(0.00099999) == "1.00"
    assert millimetres(0.0000203) == "0.020"
    assert millimetres(0.0) == "0.000"
