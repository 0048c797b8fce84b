"""Drake's log is recorded; its messages are left without places in its source code."""

import logging

import pytest

from aerodrake.model.vehicle.drake_log import plain, recorded_log


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ("<literal-string>.urdf:87: warning: While\nparsing", "While parsing"),
        ("Failure at bazel-out/x/joint.h:159 in Joint(): 'a' failed.", "'a' failed."),
        ("ERROR: In vtkReader.cxx, line 193: no file", "ERROR: In no file"),
        ("geometry data: /tmp/a-b/c/bad.obj.", "geometry data: bad.obj."),
        ("see https://drake.mit.edu/x/y.html", "see https://drake.mit.edu/x/y.html"),
    ],
)  # fmt: skip
def test_places_are_left_out(message, expected):
    assert plain(message) == expected


def test_the_log_is_as_before_after_an_error(caplog):
    log = logging.getLogger("drake")
    with pytest.raises(ValueError), recorded_log() as messages:
        log.warning("inside")
        raise ValueError
    log.warning("outside")
    assert messages == ["inside"]
    assert [record.getMessage() for record in caplog.records] == ["outside"]
