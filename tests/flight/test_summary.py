"""Tests of the summary with made-up logs whose figures are known."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.log import FlightLog
from aerodrake.flight.summary import headline, millimetres, summarize, to_json
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.reference_curve import hover_then_follow
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Clover, Hover, MovingTarget, Rates, Residual, Scenario, Supervisor

VEHICLE = VehicleModel.load(Scenario())
PERIOD_S = 0.01
TICK_S = 0.02


CLOVER = Scenario(name="made", seed=5, reference=Clover(start_s=3, lap_s=24), settle_s=1)


def made(
    error=lambda t: np.zeros_like(t),
    base_error=lambda t: np.zeros_like(t),
    mode=lambda t: np.full_like(t, Mode.HOVER),
    *,
    settle_s=1.0,
    until_s=30.0,
    **others,
) -> FlightLog:
    """A log of `CLOVER` with the given errors in m and modes over reference time in s."""
    samples = round((settle_s + until_s) / PERIOD_S) + 1
    t = np.arange(samples) * PERIOD_S - settle_s
    t = np.round(t, 9)
    curve = make_reference(CLOVER.reference, VEHICLE.p_E)
    p_Ed, _ = hover_then_follow(curve, VEHICLE.p_E, t)
    diagonal = np.ones(3) / math.sqrt(3)  # An error has three components.
    signals = {
        "time_s": t,
        "p_Ed_m": p_Ed,
        "p_E_m": p_Ed + np.outer(error(t), diagonal),
        "p_Bd_m": np.zeros((samples, 3)),
        "p_B_m": np.outer(base_error(t), -diagonal),
        "quaternion": np.tile([1.0, 0, 0, 0], (samples, 1)),
        "q_rad": np.tile(Scenario().vehicle.working_rad, (samples, 1)),
        "tool_axis": np.tile([0.0, 0, -1.0], (samples, 1)),
        "tool_axis_d": np.zeros((samples, 3)),
        "mode": mode(t),
        "supervisor_mode": np.zeros(samples),
        "conditions": np.zeros((samples, len(conditions(Supervisor())))),
        "qp_status": np.full(samples, QpStatus.UNCONSTRAINED, float),
        "prediction_error_m_s": np.zeros((samples, 3)),
        "nominal_prediction_error_m_s": np.zeros((samples, 3)),
        "tick_ms": np.full(math.ceil((samples - 1) * PERIOD_S / TICK_S), 1.0),
    }
    ending = {"exit_reason": "completed", "exit_cause": "", "wall_s": 4.0}
    for key in set(others) & set(ending):
        ending[key] = others.pop(key)
    return FlightLog(signals | others, vehicle=VEHICLE, **ending)


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


def steps(t):
    """1 mm, then 2 mm from 3 s, 4 mm from 15 s, 8 mm after 27 s; and 1 m in the hover before."""
    levels = [t < 0, t < 3 - 1e-9, t < 15 - 1e-9, t < 27 + 1e-9]
    return np.select(levels, [1.0, 0.001, 0.002, 0.004], 0.008)


def figures(log: FlightLog, scenario: Scenario = CLOVER):
    return json.loads(to_json(summarize(scenario, log)))


@pytest.mark.parametrize("which", ["error", "base_error"])
def test_errors_over_the_windows_of_the_paper(which):
    """300 samples of 1 mm, 1200 of 2, 1201 of 4 (both ends of the lap count), 300 of 8."""
    error = figures(made(**{which: steps}))[which]
    total = 300 + 1200 + 1201 + 300
    assert error["mean_m"] == pytest.approx((0.3 + 2.4 + 4.804 + 2.4) / total)
    squares = 300 * 1 + 1200 * 4 + 1201 * 16 + 300 * 64
    assert error["rms_m"] == pytest.approx(1e-3 * math.sqrt(squares / total))
    assert error["max_m"] == pytest.approx(0.008)
    assert error["lap_mean_m"] == pytest.approx((2.4 + 4.804) / (1200 + 1201))
    assert error["settled_mean_m"] == pytest.approx((4.804 + 2.4) / (1201 + 300))
    assert error["approach_s"] == 0


def test_errors_of_end_effector_and_base_are_independent():
    both = figures(made(error=steps))
    assert both["base_error"]["max_m"] == 0 and both["error"]["max_m"] > 0


def test_approach_is_the_first_time_within_d_h():
    def error(t):
        return np.where(np.abs(t - 2.2) < 0.005, 0.0749, np.where(t < 5, 0.0751, 0.01))

    scenario = Scenario(reference=MovingTarget(), settle_s=1)
    assert figures(made(error), scenario)["error"]["approach_s"] == pytest.approx(2.2)


def test_the_approach_does_not_count_in_the_initial_hover():
    error = figures(made(lambda t: np.where(t < 0, 0.0, 1.0)))["error"]
    assert error["approach_s"] is None


@pytest.mark.parametrize(
    ("until_s", "flown"),
    [
        (-0.1, set()),
        (0.1, {"mean_m", "rms_m", "max_m", "approach_s"}),
        (14.99, {"mean_m", "rms_m", "max_m", "approach_s"}),
        (15.0, {"mean_m", "rms_m", "max_m", "approach_s", "settled_mean_m"}),
        (26.99, {"mean_m", "rms_m", "max_m", "approach_s", "settled_mean_m"}),
        (27.0, {"mean_m", "rms_m", "max_m", "approach_s", "settled_mean_m", "lap_mean_m"}),
    ],
)
def test_windows_that_were_not_flown_are_null(until_s, flown):
    for which in ("error", "base_error"):
        error = figures(made(until_s=until_s))[which]
        assert {key for key, value in error.items() if value is not None} == flown


def test_another_reference_than_the_scenarios_has_no_lap_mean():
    faster = replace(CLOVER, reference=Clover(start_s=3, lap_s=20))
    error = figures(made(steps), faster)["error"]
    assert error["lap_mean_m"] is None and error["mean_m"] > 0


def test_references_without_laps_have_no_lap_mean():
    for reference in (Hover(), MovingTarget()):
        scenario = Scenario(reference=reference, settle_s=1)
        assert figures(made(), scenario)["error"]["lap_mean_m"] is None


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


def test_the_same_flight_gives_the_same_text():
    assert to_json(summarize(CLOVER, made(steps))) == to_json(summarize(CLOVER, made(steps)))


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
