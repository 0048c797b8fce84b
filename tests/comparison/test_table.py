"""The figures of a comparison, beside the paper's."""

import pytest

from aerodrake.comparison.table import comparison_table, papers_rows
from aerodrake.flight.summary import summarize


@pytest.fixture
def summaries(short_flight):
    """Of an integral model at 30.2 mm, another at 12.2 mm, one lost and one failed."""
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
    """The cells of each row by its first."""
    cells = [
        [c for c in line.replace(": ", ":").split("  ") if c.strip()]
        for line in text.splitlines()
        if line
    ]
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in cells if len(row) > 1}


def test_rows_beside_the_papers(summaries):
    """59.6 % lower, as the paper has it of the same two numbers."""
    found = rows(comparison_table(summaries, "clover"))
    assert found["integral"][0] == found["paper:integral"][0] == "30.20"
    assert found["modified"][0] == found["paper:proposed"][0] == "12.20"
    assert found["modified"][2] == found["paper:proposed"][1] == "-59.6 %"
    assert found["modified"][-1] == "completed"
    target = rows(comparison_table(summaries, "moving_target"))
    assert target["paper:proposed"] == ["5.00"]  # It has no lap.
    assert "paper" not in comparison_table(summaries, "hover")


def test_what_was_lost_or_failed_is_shown(summaries):
    text = comparison_table(summaries, "clover")
    assert rows(text)["clik"][-1] == "lost:tilt of 61 deg at 2.00 s"
    assert rows(text)["fixed_weights"] == ["failed:MemoryError"]
    assert "None" not in text and "nan" not in text
    assert all(line == line.rstrip() for line in text.splitlines())


def test_without_the_integral_model_there_is_nothing_to_hold_against(summaries):
    del summaries["integral"]
    assert rows(comparison_table(summaries, "hover"))["modified"][2] != "-59.6 %"
    summaries["integral"] = summaries["fixed_weights"]
    assert " %" not in comparison_table(summaries, "hover")


def test_the_papers_lap_is_not_held_against_other_figures():
    assert [row[3] for row in papers_rows("clover", "lap_mean_m")] == ["", "-59.6 %"]
    assert [row[3] for row in papers_rows("clover", "mean_m")] == [""]
