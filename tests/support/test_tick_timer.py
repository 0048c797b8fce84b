"""Wall times of ticks, measured by wrapping a controller's method."""

import time

from aerodrake.support.tick_timer import TickTimer


class Controller:
    def solve_tick(self, context, tick):
        time.sleep(0.002)
        return context + tick


def test_each_call_is_timed_and_returns_its_result():
    controller = Controller()
    timer = TickTimer(controller)
    assert controller.solve_tick(1, 2) == 3 and controller.solve_tick(3, 4) == 7
    assert len(timer.times_ms) == 2 and min(timer.times_ms) > 2


def test_other_controllers_of_the_class_are_not_timed():
    timer = TickTimer(Controller())
    Controller().solve_tick(1, 2)
    assert not timer.times_ms


def test_a_controller_without_the_method_is_not_timed():
    assert TickTimer(object()).times_ms == []
