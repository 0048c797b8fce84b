"""Plant by engine: MuJoCo has the scenario's mismatch and payload, and may be missing."""

import sys
from dataclasses import replace

import pytest

from aerodrake.cli import main
from aerodrake.scenario import Mismatch, Payload, Physics, Scenario
from aerodrake.support.errors import ScenarioError
from aerodrake.wiring.plant import make_plant


def test_mismatch_payload_integrator_and_substeps_reach_mujoco(vehicle, scenario):
    physics = Physics(engine="mujoco", integrator="rk4", substeps=4)
    system = make_plant(
        replace(
            scenario,
            physics=physics,
            payload=Payload(mass_kg=0.1),
            mismatch=Mismatch(mass_scale=1.5, inertia_scale=0.5),
        ),
        vehicle,
    )
    model = system.engine.model
    assert model.body_mass.sum() == pytest.approx(1.5 * vehicle.mass + 0.1)
    assert model.opt.timestep == pytest.approx(scenario.rates.plant_step_s / 4)
    assert model.opt.integrator == 1  # mjINT_RK4


@pytest.mark.parametrize("key", ["integrator", "substeps"])
def test_keys_of_mujoco_are_refused_with_drake(key):
    value = {"integrator": "rk4", "substeps": 2}[key]
    with pytest.raises(
        ScenarioError, match=rf"physics.{key}: expected .* physics.engine drake.* got {value}$"
    ):
        Scenario(physics=Physics(**{key: value}))


def test_a_missing_mujoco_is_one_line(monkeypatch, capsys, tmp_path):
    for name in [
        name for name in sys.modules if name.startswith("aerodrake.") and "mujoco" in name
    ]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    command = ["run", "hover", "--set", "physics.engine=mujoco", "--out", str(tmp_path / "out")]
    assert main(command) == 2
    output, error = capsys.readouterr()
    assert "physics.engine: mujoco expects the extra [mujoco]: pip install" in error
    assert error.count("\n") == 1 and not (tmp_path / "out").exists()
