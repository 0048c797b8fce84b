"""Spellings of decimal numbers."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.support.decimals import read_decimal


@given(st.floats(allow_nan=False, allow_infinity=False) | st.integers())
def test_numbers_are_read_as_python_writes_them(number):
    assert read_decimal(repr(number)) == float(number)


@pytest.mark.parametrize("text", ["1", "+1.", "-.5", "1e3", "1.E-03", "007"])
def test_decimal_spellings(text):
    assert read_decimal(text) == float(text)


@pytest.mark.parametrize(
    "text",
    [
        *("", " 1", "1 ", "5_0", "１", "١", "0x10", "1e", "e1", ".", "1,5", "1.2.3", "--1", "−1"),
        *("nan", "inf", "-Infinity", "1d3", "1j", "True", "1e5_0", "1\n", "1e 5"),
    ],
)
def test_other_texts_are_no_numbers(text):
    assert math.isnan(read_decimal(text))


@given(st.text(max_size=8))
def test_any_text_is_a_number_or_nan(text):
    number = read_decimal(text)
    assert math.isnan(number) or (text.isascii() and number == float(text))
