"""Where the samples of a stage are kept: apart from those of another station."""

from dataclasses import replace
from pathlib import Path

import pytest

from aerodrake.learning.collection import describe, place
from aerodrake.learning.stages import quick_stages
from aerodrake.scenario import Mismatch, Mpc, Sensors


@pytest.mark.parametrize(
    ("change", "is_another"),
    [
        ({"sensors": Sensors(base_delay_s=0.01)}, True),
        ({"mismatch": Mismatch(rotor_lag_scale=1.2)}, True),
        ({"mpc": Mpc(horizon=7)}, False),
    ],
)
def test_samples_belong_to_a_station(scenario, change, is_another):
    stage, *_ = quick_stages()
    kept, other = (
        place(Path("data"), describe(each, stage))
        for each in (scenario, replace(scenario, **change))
    )
    assert (kept != other) == is_another
    assert kept.parent == Path("data") and kept.name.startswith(f"{stage.name}-")
