"""The guards of online learning, and the paper's printed form without them."""

import dataclasses

from aerodrake.scenario import Guards, Residual

CHANGED = Guards(0.02, 0.4, 0.6, False, 2.0, 0.006)


def test_guards_are_the_keys_of_their_names():
    config = dataclasses.replace(Residual(), **CHANGED._asdict())
    assert config.guards == CHANGED
    assert all(Residual().guards)


def test_as_printed_turns_every_guard_off():
    config = dataclasses.replace(Residual(as_printed=True), **CHANGED._asdict())
    assert config.guards == Guards() and not any(Guards())
