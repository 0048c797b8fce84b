"""The figure of a sweep."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from aerodrake.sweeps.distributions import parse_distribution
from aerodrake.sweeps.figure import _draw_distribution, _draw_parameter, plot_sweep
from aerodrake.sweeps.outcomes import Outcomes, three_digits

pytestmark = pytest.mark.filterwarnings("error")


def outcomes(distribution: str, values, error_mm, endings=None) -> Outcomes:
    error_m = 1e-3 * np.array(error_mm, dtype=float)
    endings = endings or ["completed"] * len(values)
    vary = {"key": parse_distribution(distribution, "key")}
    trials = np.arange(len(values))
    return Outcomes(trials, endings, error_m, {"key": values}, "mean_m", vary)


def drawn(draw, *arguments):
    """Returns axes after they were drawn."""
    figure = Figure()
    axes = figure.add_subplot()
    draw(axes, *arguments)
    FigureCanvasAgg(figure).draw()
    return axes


@pytest.mark.parametrize("distribution", ["uniform(0, 2)", "normal(1, 1)", "linspace(0, 2, 3)"])
@pytest.mark.parametrize("values", [[0.5], [2, 0, 0.5], [0.1 * i for i in range(11)]])
def test_numbers_that_are_drawn_are_at_their_values(distribution, values):
    """However few they are: three trials of a uniform distribution are no categories."""
    axes = drawn(_draw_parameter, outcomes(distribution, values, np.ones(len(values))), "key")
    points = next(line for line in axes.lines if line.get_marker() == ".")
    np.testing.assert_array_equal(points.get_xdata(), values)
    ticks = axes.get_xticks()
    np.testing.assert_allclose(np.diff(ticks, 2), 0, atol=1e-9)
    low, high = axes.get_xlim()
    assert low <= min(values) and max(values) <= high and low < high


@pytest.mark.parametrize(
    ("choices", "values", "labels"),
    [
        ("10, 15", [15, 10, 15], ["10", "15"]),
        (", ".join(map(str, range(20))), [*range(20)], [*map(str, range(20))]),
        ("off, online", ["online", "off"], ["off", "online"]),
        ("true, false", [True, False], ["false", "true"]),
        ("[0, 1], [1, 0]", [[1, 0], [0, 1]], ["[0, 1]", "[1, 0]"]),
    ],
)
def test_choices_are_categories(choices, values, labels):
    data = outcomes(f"choice({choices})", values, np.ones(len(values)))
    axes = drawn(_draw_parameter, data, "key")
    assert [text.get_text() for text in axes.get_xticklabels()] == labels
    medians = next(line for line in axes.lines if line.get_marker() == "_")
    assert len(medians.get_xdata()) == len(labels)


def test_a_grid_has_a_line_of_medians():
    data = outcomes("linspace(0, 1, 2)", [0, 1, 0, 1, 0], [1, 2, 3, 4, 8])
    axes = drawn(_draw_parameter, data, "key")
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[0, 3], [1, 3]])


@pytest.mark.parametrize("scale", [1e-5, 1e-3, 1.0, 100.0])
def test_quantiles_have_three_significant_digits(scale):
    error = scale * np.linspace(1.111111, 2.222222, 101)
    axes = drawn(_draw_distribution, outcomes("uniform(0, 1)", [0.5] * 101, error))
    quantiles = np.percentile(error, [50, 90, 95])
    expected = [f"{float(f'{value:.3g}'):g}" for value in quantiles]
    shown = [f"{float(part.split()[-1]):g}" for part in axes.get_title(loc="left").split("    ")]
    assert shown == expected


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0.00"), (0.0123456, "0.0123"), (1.5, "1.50"), (99.96, "100.0"), (1234.4, "1234"),
     (2.5e-7, "2.50e-07"), (3e9, "3.00e+09")],
)  # fmt: skip
def test_three_digits(value, text):
    assert three_digits(value) == text


@pytest.mark.parametrize("error", [[np.nan] * 3, [0.0, 1e-9, 1e24], [5e-324, 1e300, 1.0], []])
def test_any_errors_are_drawn(error, tmp_path):
    endings = ["completed" if np.isfinite(e) else "lost" for e in error]
    for kind in ("uniform(0, 1)", "choice(0, 1)", "linspace(0, 1, 2)"):
        values = [i % 2 for i in range(len(error))]
        plot_sweep(outcomes(kind, values, error, endings), "title", tmp_path / "a.png")
        assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
