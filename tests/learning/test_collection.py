"""File names of the samples of a run, distinct for each station."""

from dataclasses import replace
from pathlib import Path

import pytest

from aerodrake.learning.collection import dataset_path, describe
from aerodrake.learning.collection_runs import quick_runs
from aerodrake.scenario import Mismatch, Mpc, Sensors


@pytest.mark.parametrize(
    ("change", "is_distinct"),
    [
        ({"sensors": Sensors(base_delay_s=0.01)}, True),
        ({"mismatch": Mismatch(rotor_lag_scale=1.2)}, True),
        ({"mpc": Mpc(horizon=7)}, False),
    ],
)
def test_samples_of_another_station_have_another_file(scenario, change, is_distinct):
    run, *_ = quick_runs()
    path, other = (
        dataset_path(Path("data"), describe(each, run))
        for each in (scenario, replace(scenario, **change))
    )
    assert (path != other) == is_distinct
    assert path.parent == Path("data") and path.name.startswith(f"{run.name}-")
