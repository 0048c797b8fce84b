"""The plant's cost in both engines, in one run."""

from dataclasses import replace

from aerodrake.bench import engines as module
from aerodrake.bench.engines import engine_figures


def test_times_of_both_engines_and_of_mujocos_steps(scenario, monkeypatch):
    short = replace(scenario, duration=0.02)
    figures = engine_figures(short, 1)
    assert list(figures) == ["drake", "mujoco", "mujoco_steps"] and min(figures.values()) > 0
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    assert list(engine_figures(short, 1)) == ["drake"]
