"""The search returns the margins of known responses, in few flights."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.comparison.margin_search import COARSE, LEAST_ERROR_M, Outcome, Search

LOST = Outcome(None, "lost", "tilt of 61 deg at 2.00 s")


def fine(error_m: float) -> Outcome:
    return Outcome(error_m, "completed")


def run(outcomes: list[Outcome]) -> Search:
    """Returns a completed search on values 0, 0.1, ... whose flights have these outcomes.

    No value may be flown twice.
    """
    search = Search([0.1 * i for i in range(len(outcomes))], {0: outcomes[0]})
    while (index := search.next()) is not None:
        assert index not in search.outcomes
        search.outcomes[index] = outcomes[index]
    return search


def crossing(search: Search, index: int | None) -> tuple[float | None, float | None]:
    """Returns the expected bracket if values cross from `index` on."""
    if index is None:
        return search.values[-1], None
    return search.values[index - 1], search.values[index]


@given(data=st.data(), count=st.integers(2, 90))
def test_the_brackets_of_a_monotonic_response_are_adjacent_values(data, count):
    """The error doubles at any value, and the flight is lost at any later one."""
    places = sorted(data.draw(st.tuples(st.integers(1, count), st.integers(1, count))))
    doubles, lost = (place if place < count else None for place in places)
    outcomes = [fine(0.001 * (1 + 0.9 * i / places[0])) for i in range(places[0])]
    outcomes += [fine(0.002 + 0.001 * i) for i in range(places[1] - places[0])]
    outcomes += [LOST] * (count - places[1])
    search = run(outcomes)
    assert search.doubles == crossing(search, doubles)
    assert search.lost == crossing(search, lost)
    reached = math.ceil((places[1] if places[1] < count else count - 1) / COARSE)
    assert len(search.outcomes) - 1 <= reached + 2 * math.log2(COARSE)


outcomes_ = st.one_of(st.just(LOST), st.floats(0, 0.01).map(fine))


@given(first=st.floats(1e-5, 0.003).map(fine), others=st.lists(outcomes_, max_size=90))
def test_the_first_crossing_of_any_response_counts(first, others):
    outcomes = [first, *others]
    search = run(outcomes)
    kinds = {
        "lost": lambda o: o.exit_reason == "lost",
        "doubles": lambda o: o.exit_reason == "lost" or o.error_m >= 2 * first.error_m,
    }
    for name, crosses in kinds.items():
        before, crossed = getattr(search, name)
        grid = {*range(0, len(outcomes), COARSE), len(outcomes) - 1}
        if crossed is None:
            assert before == search.values[-1] and not any(crosses(outcomes[i]) for i in grid)
            continue
        index = search.values.index(crossed)
        assert crosses(outcomes[index]) and before == search.values[index - 1]
        assert not any(crosses(outcomes[i]) for i in search.outcomes if i < index)
        assert not any(crosses(outcomes[i]) for i in grid if i < index)


def test_nothing_is_flown_if_the_undisturbed_flight_is_lost():
    for end in (LOST, Outcome(None, "failed", "MemoryError")):
        search = run([end, fine(0.1), fine(0.1)])
        assert search.outcomes == {0: end}
        assert search.doubles == search.lost == (None, 0.0)


def test_nothing_is_flown_without_values():
    search = run([fine(0.1)])
    assert search.doubles == search.lost == (0.0, None) and len(search.outcomes) == 1


@pytest.mark.parametrize("error_m", [0.0, 1e-16, LEAST_ERROR_M])
def test_errors_at_rounding_level_do_not_count_as_doubled(error_m):
    below, above = math.nextafter(2 * LEAST_ERROR_M, 0), 2 * LEAST_ERROR_M
    assert run([fine(error_m), fine(below)]).doubles == (0.1, None)
    assert run([fine(error_m), fine(above)]).doubles == (0.0, 0.1)


def test_a_flight_without_the_error_counts_as_doubled_but_not_as_lost():
    search = run([fine(0.01), fine(None)])
    assert (search.doubles, search.lost) == ((0.0, 0.1), (0.1, None))


def test_outcomes_are_read_from_summaries():
    summary = {"error": {"mean_m": 0.01, "lap_mean_m": None}, "exit_reason": "completed"}
    summary["exit_cause"] = ""
    assert Outcome.of(summary, "mean_m") == fine(0.01)
    assert Outcome.of(summary, "lap_mean_m") == fine(None)
    failed = {"exit_reason": "failed", "exit_cause": "MemoryError"}
    assert Outcome.of(failed, "mean_m") == Outcome(None, "failed", "MemoryError")
    assert [o.is_lost for o in (fine(1.0), LOST, Outcome.of(failed, "mean_m"))] == [
        *(False, True, True)
    ]
