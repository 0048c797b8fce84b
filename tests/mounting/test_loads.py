"""Largest loads, checked against Drake's mass matrix and forces of gravity."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.mounting.loads import joint_loads
from tests.arm_urdfs import LIMIT, joint, link, plant, read, robot

MOTOR = """<transmission><type>SimpleTransmission</type><joint name="j"/><actuator name="m">
<drake:gear_ratio value="10"/><drake:rotor_inertia value="1e-4"/></actuator></transmission>"""
PARTS = (link("b"), link("c", 0.3), joint("k", "b", "c", inner=LIMIT), MOTOR)


@pytest.fixture(scope="module")
def loads(tmp_path_factory):
    text = robot(link("a"), joint("j", "a", "b", inner=LIMIT), *PARTS)
    arm = read(text, tmp_path_factory.mktemp("arm")).arm
    return joint_loads(arm, list(arm.joints))


@pytest.fixture(scope="module")
def reference() -> MultibodyPlant:
    return plant(robot(link("world", 0), joint("j", "world", "b", inner=LIMIT), *PARTS))


def test_inertia(loads, reference):
    context, inertias = reference.CreateDefaultContext(), []
    for q in np.linspace(-2, 2.5, 200):
        reference.SetPositions(context, [0.0, q])
        inertias.append(np.diag(reference.CalcMassMatrix(context)))
    largest = np.max(inertias, axis=0)
    assert [loads[name].inertia for name in "jk"] == pytest.approx(largest, rel=0.02)


def test_torque(loads, reference):
    """A joint that points anywhere has loads up to that of the worst direction of gravity."""
    context, torques = reference.CreateDefaultContext(), []
    for q in np.linspace(-2, 2.5, 60):
        for first in np.linspace(-3, 3, 60):
            reference.SetPositions(context, [first, q])
            torques.append(np.abs(reference.CalcGravityGeneralizedForces(context)))
    largest = np.max(torques, axis=0)
    ratios = np.array([loads[name].torque for name in "jk"]) / largest
    assert (ratios > 0.97).all() and (ratios < 1.6).all()
