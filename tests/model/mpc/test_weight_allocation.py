"""Weight allocation: cases and numbers of the paper, and all combinations of distances."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.mpc.weight_allocation import Mode, allocate, next_mode
from aerodrake.scenario import Allocation

FLIGHT, COORDINATED, HOVER, ADJUSTMENT = Mode
CONFIG = Allocation()
D_H, D_F, D_EDGE = CONFIG.d_h_m, CONFIG.d_f_m, CONFIG.d_edge_m

BOUNDARIES = [D_H, 1.1 * D_H, D_F, 1.1 * D_F, D_EDGE]
SPECIAL = [0.0, 5e-324, 1e9, *BOUNDARIES]
SPECIAL += [math.nextafter(d, to) for d in BOUNDARIES for to in (0.0, math.inf)]
distances = st.one_of(st.sampled_from(SPECIAL), st.floats(0, 2), st.floats(0, 1e6))
diameters = st.one_of(st.sampled_from([0.0, 1e-3, D_H, 1.0, math.inf]), st.floats(0, 3))
modes = st.sampled_from(Mode)
configs = st.sampled_from(
    [
        CONFIG,
        Allocation(k_mn=3.0, k_mp=0.1, d_f_m=0.08, d_edge_m=0.08),
        Allocation(k_q=0.0, k_m=0.0, k_d=0.0, d_o_floor_m=1e-4),
        Allocation(hysteresis=0.0),
    ]
)


@given(configs, modes, distances, distances, diameters)
def test_weights_are_finite_and_in_range_for_all_distances(config, last, d_e, d_o, d_g):
    weights = allocate(config, last, d_e, d_o, d_g)
    assert weights.mode is next_mode(config, last, d_e, d_o, d_g)
    for weight, gain in (
        (weights.w_q, config.k_q),
        (weights.w_m, config.k_m),
        (weights.w_d, config.k_d),
    ):
        assert math.isfinite(weight)
        assert weight > 0 if gain > 0 else weight == 0
    assert -1 <= weights.gamma <= 1
    match weights.mode:
        case Mode.FLIGHT:
            assert weights.gamma == 0
        case Mode.COORDINATED:
            assert 0 < weights.gamma <= 1
        case Mode.HOVER:
            assert weights.gamma == 1
        case Mode.ADJUSTMENT:
            assert -1 <= weights.gamma < 0


@given(configs, distances, distances, diameters)
def test_modes_are_the_cases_of_the_paper_in_printed_order(config, d_e, d_o, d_g):
    """Outside the hysteresis bands, whatever the last mode was; without hysteresis everywhere."""
    d_h, d_f = config.d_h_m, config.d_h_m if d_g < config.d_h_m else config.d_f_m
    outward = 1 + config.hysteresis
    if d_f < d_e <= outward * d_f or d_h < d_o <= outward * d_h:
        return
    if d_e > d_f:
        expected = FLIGHT
    elif d_o > d_h:
        expected = ADJUSTMENT
    elif d_g < d_h:
        expected = HOVER
    else:
        expected = COORDINATED
    assert {next_mode(config, last, d_e, d_o, d_g) for last in Mode} == {expected}


@pytest.mark.parametrize("last", Mode)
def test_every_mode_is_reachable_from_every_mode(last):
    reached = {
        next_mode(CONFIG, last, d_e, d_o, d_g)
        for d_e, d_o, d_g in itertools.product((0, 2), (0, 0.2), (0, 1))
    }
    assert reached == set(Mode)


def sweep(config, mode, path, at):
    """Returns the (value, mode) pairs at which the mode changes along a path of values."""
    changes = []
    for d in path:
        new = next_mode(config, mode, **{**at, **d})
        if new is not mode:
            changes.append((next(iter(d.values())), new))
            mode = new
    return changes


@pytest.mark.parametrize("hysteresis", [0.1, 0.5])
@pytest.mark.parametrize(
    ("inner", "outer", "key", "boundary", "at"),
    [
        (COORDINATED, FLIGHT, "d_e", D_F, {"d_o": 0.0, "d_g": 1.0}),
        (HOVER, FLIGHT, "d_e", D_H, {"d_o": 0.0, "d_g": 0.0}),
        (COORDINATED, ADJUSTMENT, "d_o", D_H, {"d_e": 0.5, "d_g": math.inf}),
        (HOVER, ADJUSTMENT, "d_o", D_H, {"d_e": 0.0, "d_g": 0.0}),
    ],
)
def test_hysteresis(inner, outer, key, boundary, at, hysteresis):
    """Outward `hysteresis` beyond the boundary, inward at it, without chatter between."""
    config = replace(CONFIG, hysteresis=hysteresis)
    outward = (1 + hysteresis) * boundary
    up = np.linspace(0, 2 * boundary, 2001)
    path = [{key: d} for d in (*up, *up[::-1])]
    (left, first), (entered, second) = sweep(config, inner, path, at)
    assert (first, second) == (outer, inner)
    assert left == pytest.approx(outward, rel=2e-3)
    assert entered == pytest.approx(boundary, rel=2e-3)

    noise = np.random.default_rng(0).uniform(0.951, 1.049, 500)
    for middle in (boundary, outward):
        chatter = [{key: middle * n} for n in noise]
        for start in (inner, outer):
            assert len(sweep(config, start, chatter, at)) <= 1


def test_gamma_is_continuous_in_coordination():
    """(k_mp + d_h) / (k_mp + d_e) from the end of the hysteresis down to d_h, and 1 within."""
    d_e = np.linspace(0, 1.1 * D_F, 5001)
    gamma = np.array([allocate(CONFIG, COORDINATED, d, 0.0, 1.0).gamma for d in d_e])
    assert np.all(gamma[d_e <= D_H] == 1)
    assert np.all(np.diff(gamma[d_e > D_H]) < 0)
    assert np.abs(np.diff(gamma)).max() < 2 * (d_e[1] - d_e[0])


@pytest.mark.parametrize(
    ("d_e", "d_o", "d_g", "mode", "gamma", "w_q", "w_m", "w_d"),
    [
        # By hand from eq. 10 and 11 at the paper's constants: k_q 1000, k_m 10, k_d 100.
        (2.0, 0.05, 1.0, FLIGHT, 0.0, 100.0, 1000.0, 5 / 1.1),
        (0.72, 0.05, 1.0, COORDINATED, 0.625, 490.625, 10 / 0.635, 5 / 1.725),
        (0.05, 0.03, 0.02, HOVER, 1.0, 1100.0, 10 / 1.01, 3 / 2.1),
        (0.05, 0.2275, 1.0, ADJUSTMENT, -0.5, 350.0, 10 / 0.51, 22.75 / 0.6),
        # gamma stops at -1 beyond the edge of the workspace.
        (0.05, 0.7, 1.0, ADJUSTMENT, -1.0, 1100.0, 10 / 1.01, 70 / 0.1),
        # |gamma| = 0.1 is raised to 0.2 in w_m only.
        (0.05, 0.1055, 1.0, ADJUSTMENT, -0.1, 110.0, 10 / 0.21, 10.55 / 1.0),
        # d_o = 0 is raised to its floor, so that J_4 does not vanish.
        (0.05, 0.0, 0.02, HOVER, 1.0, 1100.0, 10 / 1.01, 1 / 2.1),
        # Not in the printed cases: close to a target trajectory too large for hovering.
        (0.05, 0.03, 1.0, COORDINATED, 1.0, 1100.0, 10 / 1.01, 3 / 2.1),
    ],
)
def test_hand_computed_values(d_e, d_o, d_g, mode, gamma, w_q, w_m, w_d):
    weights = allocate(CONFIG, mode, d_e, d_o, d_g)
    assert weights.mode is mode
    values = (weights.gamma, weights.w_q, weights.w_m, weights.w_d)
    assert values == pytest.approx((gamma, w_q, w_m, w_d), rel=1e-12)


def test_labels():
    assert [mode.label for mode in Mode] == ["flight", "coordinated", "hover", "adjustment"]


@given(distances, distances, diameters)
def test_fixed_weights_do_not_depend_on_distances(d_e, d_o, d_g):
    """They are those of fixed_gamma at d_o = d_h / 2; the mode is reported as usual."""
    fixed = Allocation(kind="fixed", fixed_gamma=0.5)
    weights = allocate(fixed, HOVER, d_e, d_o, d_g)
    assert weights.mode is next_mode(CONFIG, HOVER, d_e, d_o, d_g)
    values = (weights.gamma, weights.w_q, weights.w_m, weights.w_d)
    assert values == pytest.approx((0.5, 350.0, 10 / 0.51, 3.75 / 1.6), rel=1e-12)


def test_default_fixed_weights_are_those_of_tracking():
    """On the target, half way to the boundary of hovering."""
    ours = allocate(Allocation(kind="fixed"), COORDINATED, 0.0, D_H / 2, 1.0)
    assert ours == allocate(CONFIG, COORDINATED, 0.0, D_H / 2, 1.0)
