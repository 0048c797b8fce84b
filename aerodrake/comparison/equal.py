"""Variants that are the same scenario, of which one is flown."""

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from aerodrake.comparison.margins import Margins
from aerodrake.scenario import Scenario

EQUAL_TO = "equal_to"
"""Key in the summary of a variant that was not flown: name of the variant that it equals."""

Equal = Mapping[str, str]
"""Name of an earlier variant with the same content, by the name of the later one."""


def equal_variants(variants: Mapping[str, Scenario]) -> dict[str, str]:
    """Returns the variants, of scenarios by name, that have the same content as an earlier one."""
    firsts: dict[str, Scenario] = {}
    equal: dict[str, str] = {}
    for name, scenario in variants.items():
        first = next((other for other, known in firsts.items() if known == scenario), None)
        if first is None:
            firsts[name] = scenario
        else:
            equal[name] = first
    return equal


def share_results(
    summaries: Mapping[str, dict[str, Any]], equal: Equal, names: Iterable[str], folder: Path
) -> dict[str, dict[str, Any]]:
    """Returns the summaries of all `names`; variants that equal another get a copy of its results.

    Args:
        summaries: Summaries of the variants that were flown.
        equal: As from `equal_variants`.
        names: All variants, in their order.
        folder: Parent of the folders of the variants.
    """
    for name, first in equal.items():
        if (folder / first).exists():
            shutil.copytree(folder / first, folder / name)
    shared = {name: summaries[first] | {EQUAL_TO: first} for name, first in equal.items()}
    return {name: {**summaries, **shared}[name] for name in names}


def share_margins(margins: Margins, equal: Equal, names: Iterable[str]) -> Margins:
    """Returns the margins of all `names`; those of variants that equal another are the same."""
    searches = {name: margins.searches[equal.get(name, name)] for name in names}
    return Margins(margins.key, searches)
