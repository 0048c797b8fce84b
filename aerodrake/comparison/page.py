"""HTML report of a comparison."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from aerodrake.comparison import margins_report
from aerodrake.comparison.engines import are_engines, difference_rows, engine_differences
from aerodrake.comparison.equal import EQUAL_TO
from aerodrake.comparison.figure import COLORS, View, draw_distances, draw_errors, draw_path
from aerodrake.comparison.margins import Margins
from aerodrake.comparison.table import comparison_rows, comparison_titles, paper_rows
from aerodrake.flight.log import FlightLog
from aerodrake.flight.summary import HEADLINES, Summaries, headline
from aerodrake.reports.drawable import drawable
from aerodrake.reports.flight_panels import draw_allocation, draw_inputs
from aerodrake.reports.flight_pictures import residual_picture
from aerodrake.reports.page import render
from aerodrake.reports.pictures import MOST_SAMPLES, Picture, sheet, timeline
from aerodrake.reports.poster import poster
from aerodrake.reports.replay import replay_page
from aerodrake.scenario import Scenario
from aerodrake.scenario.schema import as_mapping, flat
from aerodrake.station import make_closed_loop

LEGEND_COLUMNS = 3
LEGEND_LINE, LEGEND_PADDING = 0.24, 0.14
"""inches, height of one line of a legend, and padding around all lines."""


class Comparison(NamedTuple):
    """Scenarios and results of one comparison.

    Attributes:
        scenario: The scenario that was compared.
        variants: Its variants by name, also those that equal another and were not flown.
        own: Name of the variant that equals the scenario with the paper's method.
        summaries: Summary of each variant, as from `share_results`.
        logs: Log of each variant that did not fail.
        margins: As from `find_margins`; None if not computed.
    """

    scenario: Scenario
    variants: Mapping[str, Scenario]
    own: str
    summaries: Summaries
    logs: Mapping[str, FlightLog]
    margins: Margins | None


def distinct_logs(comparison: Comparison) -> dict[str, FlightLog]:
    """Returns the log of each variant that was flown, without those that equal another."""
    summaries = comparison.summaries
    return {n: log for n, log in comparison.logs.items() if EQUAL_TO not in summaries[n]}


def comparison_page(
    comparison: Comparison, resolved: str, commands: Sequence[str], date: str = ""
) -> str:
    """Returns the HTML page of one comparison.

    Args:
        comparison: The comparison to show.
        resolved: The scenario as YAML, with the paths of the user's own files.
        commands: Command that repeats the comparison, then one for each variant's flight.
        date: Date and time of the flights; empty for none.
    """
    scenario, variants, own, summaries, logs, margins = comparison
    distinct = distinct_logs(comparison)
    key, kind = headline(summaries), scenario.reference.kind
    shown = variants.get(own, scenario)
    return render(
        "comparison.html",
        make_closed_loop(shown),
        replay_page(logs[own], shown) if own in logs else "",
        date=date,
        poster=poster(logs[own], shown) if own in logs else "",
        scenario=scenario,
        own=own,
        colors=COLORS,
        titles=comparison_titles(summaries),
        rows=comparison_rows(summaries),
        papers=paper_rows(kind, key),
        pictures=list(_pictures(distinct, own, shown)),
        changes={name: changes(scenario, variant) for name, variant in variants.items()},
        is_of_engines=are_engines(variants),
        differences=difference_rows(engine_differences(logs)),
        margins=margins and _margins(margins),
        resolved=resolved,
        commands=commands,
    )


def changes(scenario: Scenario, variant: Scenario) -> list[tuple[str, str, str]]:
    """Returns key, value in the scenario and value in the variant, for each key that differs."""
    before, after = (
        {key: str(value) for key, value in flat(as_mapping(config)).items()}
        for config in (scenario, variant)
    )
    return [
        (key, before.get(key, ""), after.get(key, ""))
        for key in {**before, **after}
        if before.get(key) != after.get(key)
    ]


def _pictures(logs: Mapping[str, FlightLog], own: str, scenario: Scenario) -> Iterator[Picture]:
    if not logs:
        return
    logs = {name: drawable(log) for name, log in logs.items()}
    thin = {name: log.thinned(MOST_SAMPLES) for name, log in logs.items()}
    top = _legend_height(len(thin))
    with sheet("errors", 3.2 + top, top=top) as (figure, done):
        draw_errors(figure.add_subplot(), thin, LEGEND_COLUMNS)
    yield Picture(
        "Errors", "Distance of the end-effector from its reference, logarithmic, by variant.", *done
    )
    rows = -(-len(thin) // 2)
    with sheet("paths", 2.1 * rows + 0.4, top=0.3) as (figure, done):
        view = View.of(thin)
        panels = list(figure.subplots(rows, 2, squeeze=False, gridspec_kw={"hspace": 0.2}).flat)
        for axes, (name, log) in zip(panels, thin.items(), strict=False):
            draw_path(axes, name, log, view)
            axes.label_outer()
        for axes in panels[len(thin) :]:
            axes.remove()
    yield Picture(
        "Paths", "Path of the end-effector of each variant; the reference is dashed.", *done
    )
    with sheet("distances", 2.6) as (figure, done):
        draw_distances(figure.add_subplot(), thin, scenario)
    yield Picture(
        "Reach",
        "d_o, the distance of the end-effector from the centre of its learning space, by variant, "
        "with d_h and d_edge.",
        *done,
    )
    if (online := "modified+online") in logs:
        yield residual_picture(logs[online], thin[online], scenario, f" of {online}")
    if own in logs:
        yield timeline(
            "own",
            f"Allocation and inputs of {own}",
            "gamma, with the modes as background; the largest commanded accelerations of base and "
            "joints as fractions of their bounds.",
            thin[own],
            draw_allocation,
            partial(draw_inputs, scenario=scenario),
        )


def _legend_height(entries: int) -> float:
    """Returns the height of a legend in inches."""
    return LEGEND_LINE * -(-entries // LEGEND_COLUMNS) + LEGEND_PADDING


def _margins(margins: Margins) -> dict[str, Any]:
    top, rows = _legend_height(len(margins.searches)), len(margins_report.PANELS)
    with sheet("margins", 2.5 * rows + top, top=top) as (figure, done):
        spaced = {"sharey": True, "squeeze": False, "gridspec_kw": {"hspace": 0.35}}
        panels = figure.subplots(rows, 1, **spaced)[:, 0]
        margins_report.draw_margins(panels, margins)
        for axes in panels:
            axes.set_ylabel("error / mm")
        panels[0].legend(loc="lower center", ncols=LEGEND_COLUMNS, bbox_to_anchor=(0.5, 1.0))
    caption = (
        "Error of the end-effector against each disturbance. A ring marks the last value before "
        "the error doubles, a cross at the top the first value at which the flight is not "
        "completed."
    )
    return {
        "meaning": " ".join(margins_report.MEANING),
        "headline": HEADLINES[margins.key],
        "columns": [title for title, _ in margins_report.COLUMNS.values()],
        "rows": margins_report.margins_rows(margins),
        "picture": Picture("Margins", caption, *done),
    }
