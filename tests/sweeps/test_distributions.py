"""Distributions: notation, samples, and their dependence on seed, trial and key."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from aerodrake.support.errors import BadInput
from aerodrake.sweeps.distributions import (
    Choice,
    Linspace,
    Normal,
    Uniform,
    make_rng,
    parse_distribution,
)

numbers = st.floats(-1e9, 1e9) | st.integers(-1000, 1000)
words = st.text(max_size=20).filter(str.isprintable) | st.sampled_from(
    ["off", "1e3", "0x1", "a,b", "true", "~", "a b"]
)
plain = numbers | words | st.booleans() | st.lists(numbers, max_size=4)

distributions = (
    st.tuples(numbers, numbers).filter(lambda ab: ab[0] < ab[1]).map(lambda ab: Uniform(*ab))
    | st.builds(Normal, numbers, st.floats(1e-9, 1e9))
    | st.lists(plain, min_size=1, max_size=5).map(lambda values: Choice(tuple(values)))
    | st.builds(Linspace, numbers, numbers, st.integers(2, 100))
)


@given(distributions)
def test_text_of_a_distribution_is_parsed_to_the_same(distribution):
    assert parse_distribution(str(distribution), "key") == distribution


@given(distributions, st.integers(0, 2**31 - 1), st.integers(0, 100_000), st.text(min_size=1))
def test_draws_are_repeatable_and_in_range(distribution, seed, trial, key):
    if isinstance(distribution, Linspace):
        values = [distribution.value(i) for i in range(distribution.count)]
        np.testing.assert_allclose(
            values, np.linspace(distribution.low, distribution.high, distribution.count), atol=1e-6
        )
        assert (values[0], values[-1]) == (distribution.low, distribution.high)
        return
    drawn, again = (distribution.draw(make_rng(seed, trial, key)) for _ in range(2))
    assert drawn == again
    if isinstance(distribution, Uniform):
        assert distribution.low <= drawn <= distribution.high
    if isinstance(distribution, Choice):
        assert drawn in distribution.values


@pytest.mark.parametrize(
    ("distribution", "cdf"),
    [
        (Uniform(-1, 3), ("uniform", (-1, 4))),
        (Normal(2, 0.5), ("norm", (2, 0.5))),
    ],
)
def test_samples_over_trials_have_the_distribution(distribution, cdf):
    drawn = [distribution.draw(make_rng(0, trial, "key")) for trial in range(2000)]
    assert kstest(drawn, *cdf).pvalue > 0.01
    others = [distribution.draw(make_rng(0, trial, "yek")) for trial in range(2000)]
    assert abs(np.corrcoef(drawn, others)[0, 1]) < 0.08


def test_choices_are_equally_likely():
    drawn = [Choice(("a", "b", "c")).draw(make_rng(0, trial, "key")) for trial in range(3000)]
    assert all(900 < drawn.count(value) < 1100 for value in "abc")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("choice(off, online)", ("off", "online")),
        ("choice(1, 2.5, 1e-3)", (1, 2.5, 0.001)),
        (" choice ([0, 0, 1], [1, 0, 0])", ([0, 0, 1], [1, 0, 0])),
        ("choice('a, b', true)", ("a, b", True)),
    ],
)
def test_choices_may_be_any_plain_values(text, values):
    assert parse_distribution(text, "key").values == values


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected one of uniform(a, b), normal(m, s), choice(x, y, ...), linspace(a, b, n)"),
        ("3", "expected one of uniform"),
        ("uniform 0,1", "expected one of uniform"),
        ("unifrom(0,1)", "no such distribution 'unifrom'; did you mean 'uniform'?"),
        ("uniform(1)", "expected uniform(a, b), got 'uniform(1)'"),
        ("uniform(0,1,2)", "expected uniform(a, b)"),
        ("uniform(1,0)", "the lower one first"),
        ("uniform(0,0)", "the lower one first"),
        ("uniform(0,.inf)", "expected two numbers"),
        ("uniform(0,.nan)", "expected two numbers"),
        ("uniform(0,x)", "expected two numbers"),
        ("uniform(false,true)", "expected two numbers"),
        ("normal(0,0)", "a standard deviation above 0"),
        ("normal(0,-1)", "a standard deviation above 0"),
        ("linspace(0,1)", "expected linspace(a, b, n)"),
        ("linspace(0,1,1)", "how many of them: 2 to 100000"),
        ("linspace(0,1,2.5)", "how many of them"),
        ("linspace(0,1,100001)", "how many of them"),
        ("choice()", "one at least"),
        ("choice(~)", "expected numbers, words"),
        ("choice({a: 1})", "expected numbers, words"),
        ("choice([[1]])", "expected numbers, words"),
        ("choice(1", "expected one of"),
        ("choice(])", "expected YAML"),
        ("choice(&a 1)", "expected a value without anchors"),
    ],
)
def test_invalid_distributions_are_refused_with_the_key(text, message):
    with pytest.raises(BadInput) as refused:
        parse_distribution(text, "wind.gust")
    assert str(refused.value).startswith("vary: wind.gust") and message in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
