"""The figure of a benchmark: all results, sorted, with their values, and no text cut off."""

import pytest
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb

from aerodrake.bench import figure as module
from aerodrake.bench.figure import bench_figure


def solver(median_ms, p99_ms, **more):
    return {"median_ms": median_ms, "p99_ms": p99_ms, "ticks": 1234} | more


def figures(constrained=True):
    """Results of a benchmark with three peers, of which one is not installed."""
    few = solver(2.0, 3.0) if constrained else solver(None, None)
    loop = {"mpc_forming_and_solving": 18.0, "mpc_overhead": 7.0, "a_long_name_of_a_system": 2.0}
    return {
        "tick": solver(0.4, 0.5, bounded=few),
        "solvers": {"without shortcut": solver(2.5, 2.75, bounded=few)},
        "peers": {
            "fast": solver(0.25, 0.3, bounded=few, version="1.2"),
            "slow": solver(6.0, 60.0, bounded=few, version="3.4"),
            "absent": solver(None, None, version=None),
        },
        "scaling": {
            "horizon_exponent": 1.9,
            "horizon": [
                {"N": N, "median_ms": N / 50, "forming_median_ms": N / 90}
                | {"peers_median_ms": {"daqp": N**2 / 500}}
                for N in (5, 15, 60)
            ],
            "joints": [
                {"joints": n, "median_ms": n / 20, "peers_median_ms": {"daqp": n / 10}}
                for n in (3, 4)
            ],
        },
        "closed_loop_over_plant": 6.5,
        "loop": {
            "systems_ms_per_s": loop | {"wind_force": 0.001},
            "plant_ms_per_s": 19.0,
            "framework_ms_per_s": 26.0,
            "closed_loop_ms_per_s": 70.0,
        },
    }


@pytest.fixture(params=[True, False], ids=["constrained", "unconstrained"])
def drawn(request):
    with rc_context({"font.size": 10}):
        figure = bench_figure(figures(request.param))
        FigureCanvasAgg(figure).draw()
        yield figure


def names(axes):
    return [label.get_text() for label in axes.get_yticklabels()]


def test_all_solvers_and_parts_are_sorted(drawn):
    solvers, few, *_, parts = drawn.axes
    expected = ["fast 1.2", "aerodrake", "aerodrake without shortcut", "slow 3.4"]
    assert names(solvers) == expected
    assert sorted(names(few)) in ([], sorted(expected))
    widths = [bar.get_width() for bar in parts.patches]
    assert widths == sorted(widths, reverse=True) == [26.0, 19.0, 18.0, 7.0, 2.0, 0.001]
    assert names(parts)[:3] == [
        *("Drake's events, caches and ports", "plant, rotors, propellers"),
        "mpc: forming and solving",
    ]


def test_values_are_written_with_units(drawn):
    solvers, _, horizon, joints, parts = drawn.axes
    assert [text.get_text().strip() for text in solvers.texts][:2] == [
        "0.25, 0.30 ms",
        "0.40, 0.50 ms",
    ]
    assert any("daqp" in text.get_text() and "7.20 ms" in text.get_text() for text in horizon.texts)
    assert any(
        "aerodrake" in text.get_text() and "0.20 ms" in text.get_text() for text in joints.texts
    )
    assert parts.texts[0].get_text().strip() == "26.0 ms, 36%"
    assert all("ms" in axes.get_xlabel() + axes.get_ylabel() for axes in drawn.axes)


def test_no_text_is_cut_off_or_over_another_panel(drawn):
    for axes in drawn.axes:
        own = axes.get_window_extent()
        for text in axes.texts:
            inside = text.get_window_extent()
            assert own.x0 <= inside.x0 and inside.x1 <= own.x1, text
    width, height = drawn.bbox.size
    for axes in drawn.axes:
        whole = axes.get_tightbbox()
        assert whole.x0 >= 0 and whole.y0 >= 0 and whole.x1 <= width and whole.y1 <= height


def test_marks_differ_in_grey():
    """By brightness, or by the shape of their dots."""
    looks = [module.OWN_DOT, module.VARIANT_DOT, module.PEER_DOT, module.FORMING]
    assert len({(look["marker"], look.get("markerfacecolor") == "white") for look in looks}) == 4
    bars = [sum(to_rgb(color)) / 3 for color in (module.INK, module.ACCENT, module.EDGE)]
    assert bars[0] + 0.15 < bars[1] < bars[2] - 0.15
