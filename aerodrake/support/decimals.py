"""Decimal numbers in text."""

import math
import re

DECIMAL = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")
"""Spelling of a decimal number, as in XML Schema."""


def read_decimal(text: str) -> float:
    """Returns the decimal number that is the whole text; NaN for any other text.

    Python's `float` also reads `5_0`, `inf` and digits of other scripts.
    """
    return float(text) if DECIMAL.fullmatch(text) else math.nan
