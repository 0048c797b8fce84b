"""Measured ticks of one controller."""

import time

from aerodrake.support.tick_times import time_ticks


class Controller:
    def solve_tick(self, context, tick):
        time.sleep(0.002)
        return context + tick


def test_each_call_is_timed_and_returns_its_result():
    controller = Controller()
    times_ms = time_ticks(controller)
    assert controller.solve_tick(1, 2) == 3 and controller.solve_tick(3, 4) == 7
    assert len(times_ms) == 2 and min(times_ms) > 2


def test_other_controllers_of_the_class_are_not_timed():
    times_ms = time_ticks(Controller())
    Controller().solve_tick(1, 2)
    assert not times_ms


def test_a_controller_without_the_method_is_not_timed():
    assert time_ticks(object()) == []
