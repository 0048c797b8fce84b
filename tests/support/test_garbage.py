"""What is there is left alone, and what is new is not."""

import gc
import weakref

from aerodrake.support.garbage import frozen_garbage


class Loop:
    """Garbage, as soon as nobody holds it."""

    def __init__(self):
        self.itself = self


def test_only_what_is_new_is_collected():
    old = Loop()
    was = weakref.ref(old)
    with frozen_garbage():
        new = Loop()
        is_new = weakref.ref(new)
        del old, new
        gc.collect()
        assert was() is not None and is_new() is None
    gc.collect()
    assert was() is None
