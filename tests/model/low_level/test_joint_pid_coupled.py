"""Joint PID on joints that share inertia, or with viscous damping: stability for any arm."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from aerodrake.model.low_level.joint_pid import JointPid, control
from aerodrake.model.vehicle.state import VehicleState

DT, W = 0.005, 40.0
GAINS = W**2, 2 * W, 5 * W**2


def make_pid(inertia, damping=None, effort=1e9) -> JointPid:
    """Returns a PID of joints without stops."""
    same = np.ones(len(inertia))
    damping = 0 * same if damping is None else damping
    return JointPid(
        inertia, damping, *GAINS, effort * same, 1e9 * same, -1e9 * same, 1e9 * same, DT
    )


def sampled_joints(inertia, damping) -> tuple[np.ndarray, np.ndarray]:
    """Returns A, B of [q, q'] under torques that are constant for a period."""
    n = len(inertia)
    M_inv, zero = np.linalg.inv(inertia), np.zeros((n, n))
    rates = np.block([[zero, np.eye(n), zero], [zero, -M_inv * damping, M_inv]])
    flow = expm(np.vstack([rates, np.zeros((n, 3 * n))]) * DT)
    return flow[: 2 * n, : 2 * n], flow[: 2 * n, 2 * n :]


def tick(pid, q, qdot, integral, q_d=0.0, qdot_d=0.0) -> tuple[np.ndarray, np.ndarray]:
    n = len(q)
    state, setpoint = np.zeros(VehicleState.size(n)), np.zeros(3 * n)
    state[7 : 7 + n], state[-n:] = q, qdot
    setpoint[:n], setpoint[n : 2 * n] = q_d, qdot_d
    return control(pid, state, setpoint, integral)


def poles(pid, inertia, damping) -> np.ndarray:
    """Returns the eigenvalues of the sampled closed loop of [q, q', integral]."""
    n, columns = len(inertia), []
    A, B = sampled_joints(inertia, damping)
    for x in np.eye(3 * n):
        torque, integral = tick(pid, *np.split(x, 3))
        columns.append(np.concatenate([A @ x[: 2 * n] + B @ torque, integral]))
    return np.linalg.eigvals(np.transpose(columns))


def two_links(length: float, angle: float) -> np.ndarray:
    """Returns the mass matrix of two point masses of 1 kg on links of 1 m and `length`."""
    both = length**2 + length * np.cos(angle)
    return np.array([[1 + length * np.cos(angle) + both, both], [both, length**2]])


def spread(inertia) -> float:
    """Returns lambda_max(M^-1 diag M): 1 if the joints share no inertia."""
    return np.linalg.eigvals(np.linalg.solve(inertia, np.diag(np.diag(inertia)))).real.max()


SINGLE = np.sort(np.abs(poles(make_pid(np.eye(1)), np.eye(1), np.zeros(1))))


@settings(max_examples=30)
@given(st.floats(0.05, 3.0), st.floats(0.1, 3.0))
def test_poles_of_two_links_are_those_of_one_joint(length, angle):
    inertia = two_links(length, angle)
    found = np.sort(np.abs(poles(make_pid(inertia), inertia, np.zeros(2))))
    np.testing.assert_allclose(found, np.repeat(SINGLE, 2), rtol=1e-3)  # Double poles.
    assert found.max() < 0.98


@given(st.integers(2, 6), st.floats(0.9, 0.999), st.integers(0, 2**32 - 1))
def test_any_mass_matrix_is_stable_where_its_diagonal_is_not(n, shared, seed):
    """Light distal links: nearly all inertia is shared, whatever the scale of each joint."""
    scale = 10.0 ** np.random.default_rng(seed).uniform(-2, 1, n)
    inertia = ((1 - shared) * np.eye(n) + shared) * np.outer(scale, scale)
    assert spread(inertia) > 9.9
    assert np.abs(poles(make_pid(inertia), inertia, np.zeros(n))).max() < 0.98
    alone = np.diag(np.diag(inertia))
    assert np.abs(poles(make_pid(alone), inertia, np.zeros(n))).max() > 1.0


@given(st.floats(1e-5, 1.0), st.floats(0.0, 10.0), st.floats(0.5, 2.0))
def test_any_damping_is_stable_even_if_misjudged(inertia, damping, factor):
    pid = make_pid(np.array([[inertia]]), np.array([factor * damping]))
    found = poles(pid, np.array([[inertia]]), np.array([damping]))
    assert np.abs(found).max() < 0.98


@pytest.mark.parametrize("inertia, damping", [(2e-5, 0.1), (0.5, 10.0), (0.03, 0.05)])
def test_a_known_damping_hardly_delays_the_joint(inertia, damping):
    """A motion of 1 rad/s^2 is followed within 0.1 mrad if the damping is known."""
    M, D = np.array([[inertia]]), np.array([damping])
    A, B = sampled_joints(M, D)
    errors = {}
    for known in (True, False):
        pid = make_pid(M, D if known else None)
        x, integral = np.zeros(2), np.zeros(1)
        for k in range(400):
            t = k * DT
            torque, integral = tick(pid, x[:1], x[1:], integral, t**2 / 2, t)
            x = A @ x + B @ torque
        errors[known] = abs((400 * DT) ** 2 / 2 - x[0])
    assert errors[True] < 1e-4
    assert errors[True] < 0.1 * errors[False] + 1e-6


def test_a_blocked_joint_does_not_displace_the_others():
    """The first joint pushes at its torque limit for 5 s against an obstacle before its goal.

    The torque that it lacks, through M, would hold the second joint 2 rad away from its goal.
    """
    inertia = two_links(0.15, 0.4)
    pid = make_pid(inertia)._replace(effort=np.array([1.0, 5.0]))
    A, B = sampled_joints(inertia, np.zeros(2))
    alone = sampled_joints(inertia[1:, 1:], np.zeros(1))
    x, integral, path = np.array([-0.3, 0, 0, 0]), np.zeros(2), []
    for k in range(3000):
        torque, integral = tick(pid, x[:2], x[2:], integral)
        assert np.all(np.abs(torque) <= pid.effort)
        if k < 1000:
            x[[1, 3]] = alone[0] @ x[[1, 3]] + alone[1] @ torque[1:]
        else:
            x = A @ x + B @ torque
        path.append(x[1])
    assert np.abs(path).max() < 0.2 and abs(path[999]) < 1e-3
    np.testing.assert_allclose(x, 0, atol=1e-3)
