"""Condensing against sums over stages and outputs."""

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.condensing import (
    Condensing,
    gradient,
    hessian,
    outputs_under,
    rows_by_input,
)
from aerodrake.model.mpc.horizon import StageResponses
from aerodrake.model.mpc.objective import StageCost
from aerodrake.scenario import Flight, Scenario

TICKS = np.array([1, 1, 2, 4])
SCALE = np.array([2.0, 2.0, 2.5, 15.0, 15.0, 12.0])  # Of three joints, the last one differs.


def responses(scenario: Scenario) -> StageResponses:
    return StageResponses(EquivalentModel.of(scenario, joints=3), TICKS, SCALE)


def condensing(scenario: Scenario) -> Condensing:
    H_input = np.random.default_rng(1).normal(size=(6, 4, 4))
    return Condensing.make(responses(scenario), TICKS, H_input + H_input.transpose(0, 2, 1))


def test_the_program_is_half_the_sum_of_the_stage_costs():
    form, rng = condensing(Scenario()), np.random.default_rng(0)
    F, N = len(form.axis), len(TICKS)
    C, c, free = rng.normal(size=(F, F)), rng.normal(size=(F, N)), rng.normal(size=(F, N))
    C += C.T
    H, g = hessian(form, C), gradient(form, StageCost(C, c), free)
    np.testing.assert_array_equal(H, H.T)

    def cost(z: np.ndarray) -> float:
        y = outputs_under(form, free, z)
        u = z.reshape(-1, N)
        inputs = sum(u[a] @ form.H_input[a] @ u[a] for a in range(len(u)))
        return inputs + sum(
            t * (y[:, k] @ C @ y[:, k] + 2 * c[:, k] @ y[:, k]) for k, t in enumerate(TICKS)
        )

    for z in rng.normal(size=(5, len(g))):
        np.testing.assert_allclose(z @ H @ z + 2 * g @ z, cost(z) - cost(0 * z), rtol=1e-9)


def test_outputs_and_rows_are_those_of_the_responses():
    ours, form, rng = responses(Scenario()), condensing(Scenario()), np.random.default_rng(0)
    z, rows = rng.normal(size=24), rng.normal(size=(2, 18))
    y = np.array([ours.G[f] @ z.reshape(6, 4)[axis] for f, axis in enumerate(ours.axis)])
    np.testing.assert_allclose(outputs_under(form, 0 * y, z), y, atol=1e-12)
    np.testing.assert_allclose(rows_by_input(form, rows) @ z, (rows @ y).T, atol=1e-12)


def test_outputs_with_identical_dynamics_share_their_response():
    kind = condensing(Scenario()).kind
    speeds, positions = kind[:6], kind[6:12]
    for kinds in (speeds, positions):
        assert kinds[0] == kinds[1] and kinds[3] == kinds[4]  # x and y, two joints.
        assert len(set(kinds)) == 4
    assert not set(speeds) & set(positions)


def test_slightly_different_responses_are_distinct():
    kind = condensing(Scenario(flight=Flight(position_gain=(9.0, 9.000001, 9.0)))).kind
    assert kind[0] != kind[1]


def test_rounding_errors_do_not_separate_responses():
    """Rounding depends on how matrices are multiplied, for example on the number of threads."""
    exact, rounded = responses(Scenario()), responses(Scenario())
    rounded.G *= 1 + 1e-15 * np.random.default_rng(0).normal(size=rounded.G.shape)
    kinds = [Condensing.make(r, TICKS, np.zeros((6, 4, 4))).kind for r in (exact, rounded)]
    np.testing.assert_array_equal(*kinds)
