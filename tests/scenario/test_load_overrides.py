"""Overrides of keys of a scenario."""

import pytest

from aerodrake.scenario import Clover, FixedAxis, Model, Mpc, OrientationOff, Push, SampleNan
from aerodrake.scenario.load import load_scenario, load_with_options
from tests.refusals import refuses


def test_faults_are_overridden_by_index(write):
    path = write("faults: [{kind: push, start_s: 1}, {kind: mpc_missed}]")
    changes = ["faults[0].start_s=2", "faults[1].kind=sample_nan", "faults[1].group=joints"]
    scenario = load_with_options(path, [("--set", change) for change in changes])
    assert scenario.faults == (Push(start_s=2.0), SampleNan(group="joints"))


def test_overrides_apply_in_order(write):
    path = write("seed: 1\nmpc: {k_e: [1, 2, 3]}\nmodel: {k_b: [4, 5, 6]}\n")
    scenario = load_with_options(
        path,
        [
            ("--set", "seed=2"),
            ("--set", "seed=3"),
            ("--set", "mpc.k_e=[7, 8, 9]"),
            ("--set", "reference.kind=clover"),
            ("--set", "reference.amplitude_m=0.3"),
            ("--set", "vehicle.rotor.lag_up_s=0.02"),
            ("--set", "name=mine"),
        ],
    )
    assert scenario.seed == 3 and scenario.mpc.k_e == (7, 8, 9) and scenario.name == "mine"
    assert scenario.reference == Clover(amplitude_m=0.3)
    assert scenario.vehicle.rotor.lag_up_s == 0.02
    assert scenario.model == Model(k_b=(4, 5, 6))


def test_elements_of_lists_are_overridden_by_index(write):
    path = write("wind: {velocity_m_s: [1, 2, 3]}\n")
    changes = ["wind.velocity_m_s[2]=0.5", "mpc.k_e[0]=7", "wind.velocity_m_s[0]=4"]
    scenario = load_with_options(path, [("--set", change) for change in changes])
    assert scenario.wind.velocity_m_s == (4, 2, 0.5)
    assert scenario.mpc.k_e == (7, *Mpc().k_e[1:])


def test_overriding_a_choice_called_kind_keeps_its_section(write):
    """Only kinds of references, orientations and faults have their own keys."""
    path = write("model: {kind: paper, k_b: [4, 5, 6]}\n")
    scenario = load_with_options(path, [("--set", "model.kind=exact")])
    assert scenario.model == Model(kind="exact", k_b=(4, 5, 6))


def test_overriding_the_kind_of_orientation(write):
    path = write("orientation: {kind: fixed, axis: [1, 0, -1]}\n")
    assert load_scenario(path).orientation == FixedAxis(axis=(1, 0, -1))
    for kind, expected in (
        ("fixed", FixedAxis(axis=(1, 0, -1))),
        ("off", OrientationOff()),
    ):
        scenario = load_with_options(path, [("--set", f"orientation.kind={kind}")])
        assert scenario.orientation == expected


def test_naming_the_same_kind_again_keeps_its_keys(write):
    path = write("reference: {kind: clover, amplitude_m: 0.3}\n")
    scenario = load_with_options(path, [("--set", "reference.kind=clover")])
    assert scenario.reference == Clover(amplitude_m=0.3)


@pytest.mark.parametrize(
    ("assignment", "expected"),
    [
        ("seed", "expected dotted.key=value, got 'seed'"),
        ("=3", "expected dotted.key=value, got '=3'"),
        ("", "expected dotted.key=value, got ''"),
        ("sed=3", "sed: unknown key; did you mean 'seed'?"),
        ("mcp.horizon=3", "mcp: unknown section; did you mean 'mpc'? (valid: "),
        ("mpc.horizn=3", "mpc.horizn: unknown key; did you mean 'horizon'?"),
        ("vehicle.rotr.lag_up_s=1", "vehicle.rotr: unknown section; did you mean 'rotor'?"),
        ("seed.x=3", "seed: unknown section"),
        ("mpc.horizon.x=3", "mpc.horizon: unknown section"),
        ("reference.lap_s=3", "reference.lap_s: unknown key"),
        ("reference.kind=clovr", "reference.kind: unknown kind 'clovr'; did you mean 'clover'?"),
        ("reference=clover", "reference: expected a mapping with a kind"),
        ("mpc=3", "mpc: expected a mapping"),
        ("kind=clover", "kind: unknown key"),
        ("mpc.horizon=x", "mpc.horizon: expected a whole number in [2, 200] stages, got 'x'"),
        ("mpc.horizon=", "mpc.horizon: expected a whole number in [2, 200] stages, got None"),
        ("duration=10 s", "duration: expected a number in [0.02, 3600] s, got '10 s'"),
        ("mpc.k_e=[1, 2", "mpc.k_e: expected YAML; line 1"),
        ("source=x", "source: unknown key"),
        ("mpc..horizon=3", "mpc.: unknown section"),
        ("faults[0].start_s=3", "faults[0]: unknown section"),
        ("mpc.k_e[3]=1", "mpc.k_e: expected an index below 3, got [3]"),
        ("mpc.k_e[0]=x", "mpc.k_e[0]: expected a number in"),
        ("mpc.k_e[-1]=1", "mpc.k_e[-1]: unknown key"),
        ("mpc.horizon[0]=1", "mpc.horizon[0]: unknown key"),
        ("kind=3", "kind: unknown key"),
        ("vehicle.rotor.min_thrust_n=30", "vehicle.rotor.min_thrust_n: expected less than"),
    ],
)
def test_bad_overrides_name_the_option(write, assignment, expected):
    """An inconsistency between keys names the file as well as the option."""
    path = write("seed: 1\n")
    message = refuses(path, ("--set", assignment))
    both = f"{path} --set {assignment}: {expected}"
    assert message.startswith((f"--set: {expected}", both))


def test_each_override_is_named_by_its_own_option(write):
    path = write("seed: 1\n")
    message = refuses(path, ("--seed", "seed=2"), ("--duration", "duration=-1"))
    assert message.startswith("--duration: duration: expected a number")
