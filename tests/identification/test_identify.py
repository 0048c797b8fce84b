"""Manoeuvres of the identification of K_B, and K_B of the packaged scenarios."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

import aerodrake.identification.identify
from aerodrake.identification.identify import (
    ARMS,
    AXES,
    BAND_HZ,
    DURATION_S,
    FLIGHTS,
    SPEED_M_S,
    Manoeuvre,
    Record,
    arm_motion,
    base_motion,
    fly,
    identify_axis,
    identify_gains,
)
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.scenario import Flight, Model, Rates, Scenario, Sensors
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput
from aerodrake.support.processes import run_parallel
from tests.in_this_process import in_this_process

TRUE_K_B = (2.0, 3.0, 4.0)


def first_order(manoeuvre: Manoeuvre) -> Record:
    """Replaces `fly` by an ideal base with `TRUE_K_B`, which is 10 % slower if the arm moves."""
    k = TRUE_K_B[manoeuvre.axis] * (0.9 if manoeuvre.arm == "moving" else 1.0)
    t = 0.02 * np.arange(3001)
    p_d = 1.0 + 0.3 * np.sin(0.9 * t)
    _, p, _ = lsim(([k], [1.0, k]), p_d - 1.0, t)
    return Record(t, p_d, p + 1.0, k * (p_d - p - 1.0))


@pytest.fixture
def ideal(monkeypatch):
    monkeypatch.setattr(aerodrake.identification.identify, "run_parallel", in_this_process)
    monkeypatch.setattr(aerodrake.identification.identify, "fly", first_order)


# What the packaged scenarios hold.


@pytest.mark.parametrize(
    ("name", "axis", "arm"), [("clover_paper", 1, "moving"), ("clover", 2, "still")]
)
def test_packaged_scenarios_have_identified_values(name, axis, arm):
    """Flies one of the six flights for each flight interface."""
    scenario = load_scenario(name)
    record = fly(Manoeuvre(scenario, axis, arm))
    fit = identify_axis(scenario, {arm: record}).fit
    k_b = scenario.model.k_b[axis]
    assert fit.interval[0] < k_b < fit.interval[1]
    assert fit.gain == pytest.approx(k_b, rel=0.02)
    assert fit.interval[1] - fit.interval[0] < 0.1 * fit.gain
    assert fit.r2 > {"position": 0.98, "trajectory": 0.94}[scenario.flight.interface]


def test_equal_stations_have_equal_k_b():
    """K_B depends only on the station."""
    papers, others = load_scenario("clover_paper"), load_scenario("moving_target_paper")
    assert papers.flight == others.flight and papers.model == others.model
    for name in ("clover", "moving_target", "hover", "figure_eight", "lissajous", "waypoints"):
        scenario = load_scenario(name)
        assert scenario.flight == Flight() and scenario.model.k_b == Model().k_b


# Manoeuvres.


@pytest.mark.parametrize("axis", range(3))
def test_the_chirp(scenario, vehicle, axis):
    motion = base_motion(scenario, vehicle, axis)
    t = np.arange(0.005, DURATION_S - 0.01, 0.01)
    p = motion.vector_values(t).T - vehicle.p_B
    assert np.all(np.delete(p, axis, axis=1) == 0)
    p = p[:, axis]
    assert p[0] == 0 and p.min() >= 0 and p.max() < 1.0
    v = np.gradient(p, 0.01)
    assert np.abs(v).max() == pytest.approx(SPEED_M_S, rel=0.01)
    turns = t[:-1][np.diff(np.sign(v)) != 0]
    assert 1 / (2 * turns[0]) == pytest.approx(BAND_HZ[0], rel=0.5)
    assert 1 / (2 * (turns[-1] - turns[-2])) == pytest.approx(BAND_HZ[1], rel=0.1)
    for order in (1, 2):  # v_d and a_d are zero.
        assert not motion.MakeDerivative(order).vector_values(t).any()


@pytest.mark.parametrize("period", [0.01, 0.005])
def test_the_chirp_is_constant_around_a_tick(vehicle, period):
    """Rounding of the tick's time and an offset of half a plant step do not change the value."""
    scenario = Scenario(rates=Rates(flight_period_s=period, sensor_period_s=period))
    motion = base_motion(scenario, vehicle, 0)
    for tick in (1, 3, 7, 1234, 2999):
        seen = [motion.value(tick * 0.02 + late)[0, 0] for late in (-1e-12, 0, 1e-12, 0.0005)]
        assert len(set(seen)) == 1
        assert seen[0] != motion.value((tick - 1) * 0.02)[0, 0]


def test_the_arm_rests_or_swings_within_its_learning_space(scenario, vehicle):
    t = np.arange(0, DURATION_S, 0.05)
    still = arm_motion(scenario, vehicle, "still").vector_values(t).T
    np.testing.assert_array_equal(still, np.tile(vehicle.working, (len(t), 1)))
    moving = arm_motion(scenario, vehicle, "moving").vector_values(t).T
    np.testing.assert_allclose(moving[0], vehicle.working, atol=1e-12)
    np.testing.assert_allclose(np.ptp(moving, axis=0), 0.15, atol=0.01)
    kinematics = Kinematics(vehicle.plant)
    moved = np.array([kinematics.arm(q)[0] for q in moving]) - vehicle.p_O
    assert np.all(np.abs(moved) < np.array(scenario.allocation.learning_space_m) / 2)
    assert np.abs(moved).max() > 0.03


def test_joints_stay_within_their_limits(scenario, vehicle):
    """The arm starts at a limit and has a joint with a small range."""
    working, upper, lower = vehicle.working.copy(), vehicle.upper.copy(), vehicle.lower.copy()
    working[1], working[2] = upper[1], lower[2]
    upper[3], lower[3] = working[3] + 0.01, working[3] - 0.02
    tight = replace(vehicle, working=working, upper=upper, lower=lower)
    q = arm_motion(scenario, tight, "moving").vector_values(np.arange(0, DURATION_S, 0.05)).T
    assert np.all(q >= lower - 1e-9) and np.all(q <= upper + 1e-9)
    assert np.ptp(q, axis=0)[[1, 2]].min() > 0.14
    assert np.ptp(q[:, 3]) == pytest.approx(0.02, abs=1e-3)


def test_a_child_process_gives_the_same_record():
    """Records are equal bit for bit; low rates make the flight short."""
    noise = Sensors(position_noise_m=0.001)
    rates = Rates(0.005, sensor_period_s=0.02, flight_period_s=0.02, arm_period_s=0.01)
    scenario = Scenario(rates=rates, sensors=noise)
    manoeuvre = Manoeuvre(scenario, 0, "moving")
    ((index, record),) = run_parallel(fly, [manoeuvre], 1)
    assert index == 0
    for name, values in vars(fly(manoeuvre)).items():
        np.testing.assert_array_equal(getattr(record, name), values)


# Identification.


def test_all_flights_of_an_axis_are_fitted(ideal):
    flown_s = []
    identification = identify_gains(Scenario(), 1, progress=flown_s.append)
    assert flown_s == [DURATION_S] * FLIGHTS
    assert tuple(identification.axes) == AXES
    for axis, k in zip(identification.axes.values(), TRUE_K_B, strict=True):
        assert tuple(axis.records) == ARMS
        assert axis.gains == {
            "still": pytest.approx(k, rel=1e-3), "moving": pytest.approx(0.9 * k, rel=1e-3)
        }  # fmt: skip
        assert 0.9 * k < axis.fit.interval[0] < axis.fit.gain < axis.fit.interval[1] < k
    assert identification.k_b == tuple(
        float(f"{axis.fit.gain:.3g}") for axis in identification.axes.values()
    )
    assert identification.identified_scenario == replace(
        Scenario(), model=Model(k_b=identification.k_b)
    )


def test_noise_differs_between_flights_and_is_reproducible(monkeypatch):
    seeds = []

    def excite(scenario, base, joints):
        seeds.append(scenario.seed)
        raise RuntimeError("flown enough")

    monkeypatch.setattr(aerodrake.identification.identify, "excite", excite)
    for seed in (0, 0, 1):
        for axis in range(3):
            for arm in ARMS:
                with pytest.raises(BadInput):
                    fly(Manoeuvre(Scenario(seed=seed), axis, arm))
    assert seeds[:6] == seeds[6:12] and len(set(seeds)) == 12
    assert all(0 <= seed < 2**31 for seed in seeds)


def test_noise_has_little_bias():
    """With 2 mm and 1 cm/s, K_B is within 2 % of its value without noise."""
    noise = Sensors(position_noise_m=0.002, velocity_noise_m_s=0.01)
    scenario = replace(load_scenario("clover_paper"), sensors=noise)
    fit = identify_axis(scenario, {"still": fly(Manoeuvre(scenario, 0, "still"))}).fit
    assert fit.gain == pytest.approx(scenario.model.k_b[0], rel=0.02)
    assert 0.95 < fit.r2 < 0.98


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [
        (
            lambda v: 0 * v + np.sin(np.arange(len(v))),
            "flight: expected .*; the fit of y has R.2 0.0",
        ),
        (lambda v: -v, "hover.yaml: model.k_b.1.: expected a number in .0.01, 50. 1/s, got -"),
        (lambda v: 99 * v, "hover.yaml: model.k_b.1.: expected a number in .0.01, 50. 1/s, got "),
        (lambda v: np.full_like(v, np.nan), "the fit of y has R.2 nan"),
    ],
    ids=["noise", "wrong way", "too fast", "not finite"],
)
def test_an_invalid_k_b_is_refused(velocity, expected, ideal, monkeypatch):
    def strange(manoeuvre):
        record = first_order(manoeuvre)
        return replace(record, v=velocity(record.v)) if manoeuvre.axis == 1 else record

    monkeypatch.setattr(aerodrake.identification.identify, "fly", strange)
    with pytest.raises(BadInput, match=expected):
        identify_gains(load_scenario("hover"), 1)


def test_a_crash_is_bad_input_and_a_failed_process_is_a_bug(ideal, monkeypatch):
    scenario = load_scenario("hover")

    def crash(*_):
        raise RuntimeError("the step failed\nat length")

    monkeypatch.setattr(aerodrake.identification.identify, "fly", fly)
    monkeypatch.setattr(aerodrake.identification.identify, "excite", crash)
    with pytest.raises(BadInput, match="along z, arm moving, it crashes: the step failed$"):
        identify_gains(scenario, 1)

    def died(function, items, jobs):
        yield 3, OSError("process ended")

    monkeypatch.setattr(aerodrake.identification.identify, "run_parallel", died)
    with pytest.raises(RuntimeError, match="^y, arm moving: its process failed$"):
        identify_gains(scenario, 1)
