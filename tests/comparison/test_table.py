"""Table of a comparison, with the paper's results."""

import pytest

from aerodrake.comparison.table import comparison_table, paper_rows
from aerodrake.flight.summary import summarize


@pytest.fixture
def summaries(short_flight):
    """Summaries of an integral model at 30.2 mm, another at 12.2 mm, a lost and a failed flight."""
    summary = summarize(*short_flight)

    def flown(lap_mean_m, reason="completed", cause=""):
        error = summary["error"] | {"lap_mean_m": lap_mean_m}
        return summary | {"error": error, "exit_reason": reason, "exit_cause": cause}

    return {
        "integral": flown(0.0302),
        "modified": flown(0.0122),
        "clik": flown(None, "lost", "tilt of 61 deg at 2.00 s"),
        "fixed_weights": {"exit_reason": "failed", "exit_cause": "MemoryError"},
    }


def rows(text: str) -> dict[str, list[str]]:
    """Returns the other cells of each row by its first cell."""
    cells = [
        [c for c in line.replace(": ", ":").split("  ") if c.strip()]
        for line in text.splitlines()
        if line
    ]
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in cells if len(row) > 1}


def test_rows_agree_with_the_papers_for_equal_errors(summaries):
    """The paper states 59.6 % less error for these two numbers."""
    shown = rows(comparison_table(summaries, "clover"))
    assert shown["integral"][0] == shown["paper:integral"][0] == "30.20"
    assert shown["modified"][0] == shown["paper:proposed"][0] == "12.20"
    assert shown["modified"][2] == shown["paper:proposed"][1] == "-59.6 %"
    assert shown["modified"][-1] == "completed"
    target = rows(comparison_table(summaries, "moving_target"))
    assert target["paper:proposed"] == ["5.00"]  # It has no lap.
    assert "paper" not in comparison_table(summaries, "hover")


def test_lost_and_failed_variants_are_shown(summaries):
    text = comparison_table(summaries, "clover")
    assert rows(text)["clik"][-1] == "lost:tilt of 61 deg at 2.00 s"
    assert rows(text)["fixed_weights"] == ["failed:MemoryError"]
    assert "None" not in text and "nan" not in text
    assert all(line == line.rstrip() for line in text.splitlines())


def test_without_the_integral_model_no_change_is_shown(summaries):
    del summaries["integral"]
    assert rows(comparison_table(summaries, "hover"))["modified"][2] != "-59.6 %"
    summaries["integral"] = summaries["fixed_weights"]
    assert " %" not in comparison_table(summaries, "hover")


def test_the_papers_results_are_shown_for_the_lap_only():
    assert [row[3] for row in paper_rows("clover", "lap_mean_m")] == ["", "-59.6 %"]
    assert paper_rows("clover", "mean_m") == []
