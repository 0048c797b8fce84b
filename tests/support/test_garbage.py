"""Objects that are not collected."""

import gc
import weakref

from aerodrake.support.garbage import frozen_garbage


class Loop:
    """A reference cycle, which only the garbage collector frees."""

    def __init__(self):
        self.itself = self


def test_only_new_objects_are_collected():
    old = Loop()
    old_reference = weakref.ref(old)
    with frozen_garbage():
        new = Loop()
        new_reference = weakref.ref(new)
        del old, new
        gc.collect()
        assert old_reference() is not None and new_reference() is None
    gc.collect()
    assert old_reference() is None
