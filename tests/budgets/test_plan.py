"""Plan of an error budget."""

import pytest

from aerodrake.budgets.flaws import present_flaws, silence
from aerodrake.budgets.plan import BudgetPlan
from aerodrake.scenario.load import load_scenario, override
from aerodrake.support.errors import BadInput

HOVER = {"payload.mass_kg": 0.1, "sensors.position_noise_m": 0.001, "wind.velocity_m_s": [1, 0, 0]}


@pytest.fixture(scope="module")
def scenario():
    return override(load_scenario("hover"), HOVER)


def active(plan: BudgetPlan, index: int) -> set[str]:
    return {flaw.name for flaw in present_flaws(plan.trial(index).resolved())}


def test_cases_have_each_flaw_alone_and_all_but_each(scenario):
    plan = BudgetPlan.make(scenario, 1)
    names = {"position noise", "wind", "payload"}
    expected = [set(), names, *({n} for n in sorted(names)), *(names - {n} for n in sorted(names))]
    flown = [active(plan, index) for index in range(plan.trials)]
    assert len(flown) == len(expected) and all(case in flown for case in expected)
    assert flown[:2] == [set(), names]


def test_only_random_cases_are_flown_with_further_seeds(scenario):
    plan = BudgetPlan.make(scenario, 3)
    first = BudgetPlan.make(scenario, 1)
    # Of the eight cases four have noise: all, noise alone, without wind, without payload.
    assert plan.trials == first.trials + 2 * 4
    assert plan.flights[: first.trials] == first.flights
    assert {seed for _, seed in plan.flights} == {0, 1, 2}
    for index in range(first.trials, plan.trials):
        assert "position noise" in active(plan, index)


def test_a_trial_alone_is_flown_by_its_command(scenario):
    plan = BudgetPlan.make(scenario, 1)
    trial = plan.trial(0)
    assert trial.parameters == silence(present_flaws(scenario))
    assert trial.resolved() == override(scenario, dict(trial.parameters))


@pytest.mark.parametrize(
    ("keys", "seeds", "message"),
    [
        ({}, 0, "seeds: expected a whole number"),
        ({}, True, "seeds: expected a whole number"),
        ({"seed": 2147483647}, 2, "seed: expected 2147483646 or less, for 2 seeds"),
        (silence(present_flaws(override(load_scenario("hover"), HOVER))), 1, "with flaws"),
    ],
)
def test_bad_plans_are_refused(scenario, keys, seeds, message):
    with pytest.raises(BadInput, match=message):
        BudgetPlan.make(override(scenario, dict(keys)), seeds)
