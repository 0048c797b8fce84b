"""Named state against Drake's own groups."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import LeafSystem

from aerodrake.systems.named_state import NamedState


class Colour(IntEnum):
    RED = 0
    BLUE = 1


class Limit(NamedTuple):
    least: float
    most: np.ndarray


class Counters(NamedTuple):
    rows: np.ndarray
    count: int
    is_full: bool
    colour: Colour


START = Counters(np.arange(6.0).reshape(2, 3), 4, False, Colour.BLUE)


class Counting(LeafSystem):
    """Adds one to each row and counts."""

    def __init__(self):
        super().__init__()
        self.state = NamedState(self, START)
        self.DeclareStateOutputPort("rows", self.state.groups["rows"])
        self.DeclarePeriodicDiscreteUpdateEvent(1.0, 0.0, self._update)

    def _update(self, context, discrete):
        last = self.state.read(context)
        full = last.count + 1 == 5
        self.state.write(discrete, Counters(last.rows + 1, last.count + 1, full, Colour.RED))


def test_a_group_for_each_field_in_order():
    context = Counting().CreateDefaultContext()
    assert context.num_discrete_state_groups() == len(Counters._fields)
    np.testing.assert_array_equal(context.get_discrete_state(0).value(), np.arange(6.0))
    assert context.get_discrete_state(1).value().tolist() == [4.0]


def test_reads_and_writes_shapes_and_types():
    system = Counting()
    context = system.CreateDefaultContext()
    first = system.state.read(context)
    assert type(first.count) is int and first.is_full is False and first.colour is Colour.BLUE
    assert first.rows.shape == (2, 3)
    context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    second = system.state.read(context)
    np.testing.assert_array_equal(second.rows, START.rows + 1)
    assert second[1:] == (5, True, Colour.RED)
    np.testing.assert_array_equal(system.get_output_port().Eval(context), second.rows.ravel())


class Limited(NamedTuple):
    count: int
    limit: Limit


class LimitedCounting(LeafSystem):
    """Counts, with a nested state."""

    def __init__(self):
        super().__init__()
        self.state = NamedState(self, Limited(3, Limit(0.5, np.arange(2.0))))
        self.DeclarePeriodicDiscreteUpdateEvent(1.0, 0.0, self._update)

    def _update(self, context, discrete):
        last = self.state.read(context)
        limit = Limit(2 * last.limit.least, last.limit.most[::-1])
        self.state.write(discrete, Limited(last.count + 1, limit))


def test_nested_fields_have_groups_of_their_own():
    system = LimitedCounting()
    assert list(system.state.groups) == ["count", "limit.least", "limit.most"]
    context = system.CreateDefaultContext()
    context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    state = system.state.read(context)
    assert type(state.count) is int and (state.count, state.limit.least) == (4, 1.0)
    np.testing.assert_array_equal(state.limit.most, [1.0, 0.0])


def test_what_was_read_is_a_copy():
    system = Counting()
    context = system.CreateDefaultContext()
    system.state.read(context).rows[:] = 0.0
    np.testing.assert_array_equal(system.state.read(context).rows, START.rows)
