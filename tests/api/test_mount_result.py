"""Text of a mounted arm's result."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from aerodrake.analysis.margins import StabilityLimit, StabilityMargin
from aerodrake.api.mount_result import MountResult


@pytest.mark.parametrize(("delay_s", "is_small"), [(0.008, True), (0.014, True), (0.015, False)])
def test_a_small_delay_margin_gets_a_caution(delay_s, is_small):
    limit = StabilityLimit(delay_s, 14.0)
    margin = StabilityMargin("base_delay", "delay", 0.0, (0.0, 0.2), None, limit)
    analysis = SimpleNamespace(is_stable=True, sentence="stable", margins={"base_delay": margin})
    hover = SimpleNamespace(error={"max_m": 0.001}, exit_reason="completed")
    lines = str(MountResult(Path("arm.yaml"), (), (), analysis, 1.0, hover)).splitlines()
    assert f"delay margin: unstable with {1e3 * delay_s:g} ms of delay" in lines[-2 - is_small]
    assert ("caution: less than 15 ms" in lines[-2]) == is_small
