"""Plans: their trials, what each depends on, and errors before any flight."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.scenario import RotorDegraded, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.scenario.schema import as_mapping
from aerodrake.support.errors import BadInput
from aerodrake.sweeps.plan import Plan
from tests.plans import by_key

DRAWN = {
    "wind.velocity_m_s[0]": "uniform(0, 2)",
    "payload.mass_kg": "normal(0.2, 0.01)",
    "residual.mode": "choice(off, offline, online)",
    "mpc.horizon": "choice(10, 15)",
}


def vary(*keys: str) -> dict[str, str]:
    return {key: DRAWN[key] for key in keys}


@settings(max_examples=40)
@given(
    st.permutations(list(DRAWN)),
    st.integers(0, 4),
    st.integers(0, 99),
    st.integers(1, 1000),
)
def test_a_trial_depends_on_seed_index_and_key_alone(keys, count, index, more):
    """Other keys, their order and the number of trials do not matter."""
    whole = Plan.make(Scenario(), vary(*DRAWN), 100).trial(index)
    part = Plan.make(Scenario(), vary(*keys[:count]), index + more).trial(index)
    assert part.seed == whole.seed
    assert part.parameters == {key: whole.parameters[key] for key in keys[:count]}


def test_seeds_differ_between_trials_and_sweeps():
    plans = [Plan.make(Scenario(seed=seed), vary("payload.mass_kg"), 50) for seed in (0, 1)]
    trials = [plan.trial(index) for plan in plans for index in range(50)]
    assert len({trial.seed for trial in trials}) == 100
    assert len({trial.parameters["payload.mass_kg"] for trial in trials}) == 100


def test_a_grid_is_flown_once_with_its_first_key_fastest():
    plan = Plan.make(
        Scenario(), by_key(["mpc.horizon=linspace(10, 20, 3)", "duration=linspace(1, 2, 2)"])
    )
    cells = [tuple(plan.trial(i).parameters.values()) for i in range(plan.trials)]
    assert cells == [(n, d) for d, n in itertools.product((1.0, 2.0), (10, 15, 20))]
    assert all(type(horizon) is int for horizon, _ in cells)


def test_more_trials_repeat_a_grid_and_another_key_does_not_change_it():
    one = Plan.make(Scenario(), by_key(["duration=linspace(1, 3, 3)"]), 7)
    two = Plan.make(
        Scenario(), by_key(["duration=linspace(1, 3, 3)", "settle_s=linspace(0, 1, 2)"]), 7
    )
    durations = [plan.trial(i).parameters["duration"] for plan in (one, two) for i in range(7)]
    assert durations == [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0] * 2
    assert len({one.trial(i).seed for i in range(7)}) == 7


def test_seeds_may_be_a_grid():
    plan = Plan.make(Scenario(), by_key(["seed=linspace(3, 5, 3)"]))
    assert [plan.trial(i).seed for i in range(3)] == [3, 4, 5]
    assert [plan.trial(i).resolved().seed for i in range(3)] == [3, 4, 5]


@settings(max_examples=40)
@given(st.integers(0, 99_999))
def test_the_drawn_values_are_flown_to_the_last_bit(index):
    trial = Plan.make(Scenario(), vary(*DRAWN), 100_000).trial(index)
    flown = as_mapping(trial.resolved())
    assert flown["seed"] == trial.seed
    assert flown["wind"]["velocity_m_s"] == [trial.parameters["wind.velocity_m_s[0]"], 0.0, 0.0]
    assert flown["payload"]["mass_kg"] == trial.parameters["payload.mass_kg"]
    assert flown["residual"]["mode"] == trial.parameters["residual.mode"]
    assert flown["mpc"]["horizon"] == trial.parameters["mpc.horizon"]


def test_vectors_faults_and_kinds_can_be_varied():
    fault = RotorDegraded(rotor=2, remaining=0.8, start_s=8, duration_s=30)
    scenario = load_scenario("hover", faults=[fault])
    plan = Plan.make(
        scenario,
        by_key(
            [
                "reference.kind=choice(clover)",
                "reference.amplitude_m=uniform(0.1, 0.2)",
                "faults[0].start_s=uniform(1, 2)",
                "wind.velocity_m_s=choice([1, 2, 3])",
            ]
        ),
        3,
    )
    flown = plan.trial(2).resolved()
    assert 0.1 <= flown.reference.amplitude_m <= 0.2 and 1 <= flown.faults[0].start_s <= 2
    assert flown.wind.velocity_m_s == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["wind.velocity_m_s[0]=uniform(0,1)", "wind.velocity_m_s=choice([1,0,0],[2,0,0])"],
            "vary: wind.velocity_m_s: expected each key once, but wind.velocity_m_s[0]",
        ),
        (
            ["wind.velocity_m_s[0]=uniform(0,1)", "wind.velocity_m_s[00]=uniform(0,1)"],
            "vary: wind.velocity_m_s[00]: expected each key once",
        ),
        (["duraton=uniform(1,2)"], "vary: duraton: unknown key; did you mean 'duration'?"),
        (["wnd.x=uniform(1,2)"], "vary: wnd: unknown section; did you mean 'wind'?"),
        (["duration=uniform(0,2)"], "duration: expected a number in [0.02, 3600] s, got 0"),
        (["duration=uniform(1,4000)"], "duration: expected a number in [0.02, 3600] s, got 4000"),
        (["duration=linspace(1,4000,2)"], "duration: expected a number in"),
        (["duration=choice(1,-1)"], "duration: expected a number in [0.02, 3600] s, got -1"),
        (["duration=choice(1,x)"], "duration: expected a number in [0.02, 3600] s, got 'x'"),
        (["duration=normal(-1,1)"], "duration: expected a number in [0.02, 3600] s, got -1"),
        (["mpc.horizon=uniform(5,20)"], "vary: mpc.horizon: is a whole number; expected choice"),
        (["mpc.horizon=normal(15,2)"], "vary: mpc.horizon: is a whole number"),
        (["mpc.horizon=linspace(10,15,5)"], "mpc.horizon: expected a whole number"),
        (["residual.mode=choice(of)"], "unknown value 'of'; did you mean 'off'?"),
        (["wind.velocity_m_s=uniform(0,1)"], "expected a list of 3 numbers in m/s, got 0"),
        (
            ["wind.velocity_m_s[3]=uniform(0,1)"],
            "velocity_m_s: expected an index below 3, got [3]",
        ),
        (["faults[0].start_s=uniform(0,1)"], "vary: faults[0]: unknown section"),
        (["vehicle.robot=choice(my.urdf)"], "vary: vehicle.robot: expected a packaged file"),
    ],
)
def test_invalid_plans_are_refused(options, message):
    with pytest.raises(BadInput) as refused:
        Plan.make(Scenario(), by_key(options), 5)
    assert message in str(refused.value) and str(refused.value).startswith("vary: ")


def test_the_number_of_trials_is_required_without_a_grid():
    for options in ([], ["duration=uniform(1, 2)"]):
        with pytest.raises(BadInput, match="trials: expected a number of trials"):
            Plan.make(Scenario(), by_key(options))
    with pytest.raises(BadInput, match=r"trials: .* in \[1, 100000\], got 100002"):
        Plan.make(
            Scenario(), by_key(["duration=linspace(1, 2, 50001)", "settle_s=linspace(0, 1, 2)"])
        )


def test_values_that_always_contradict_each_other_are_refused():
    late = Plan.make(Scenario(), by_key(["sensors.base_delay_s=uniform(0.001, 0.009)"]), 5)
    with pytest.raises(BadInput, match="sensors.base_delay_s: trial 0: expected a multiple"):
        late.check()
    Plan.make(Scenario(), by_key(["sensors.base_delay_s=choice(0.0011, 0.002)"]), 20).check()


def test_errors_of_drawn_values_name_the_distribution():
    drawn = Plan.make(Scenario(seed=5), by_key(["payload.mass_kg=normal(0, 0.1)"]), 1)
    assert drawn.trial(0).parameters["payload.mass_kg"] < 0
    with pytest.raises(BadInput, match=r"^vary: payload.mass_kg: trial 0: expected .* got -0\."):
        drawn.check()


def test_errors_of_the_shared_scenario_name_the_scenario():
    scenario = load_scenario("hover", {"vehicle.working_rad": [0, 1]})
    with pytest.raises(BadInput, match="^hover: vehicle.working_rad: expected 6 angles"):
        Plan.make(scenario, by_key(["duration=uniform(1, 2)"]), 3).check()
