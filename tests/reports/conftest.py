"""What tests of pages share: a browser, and visits to the fixture `path` of their module."""

import pytest

from tests.browser import DESKTOP, PHONE, chromium, visit


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def desktop(browser, path):
    with visit(browser, path, DESKTOP) as visited:
        yield visited


@pytest.fixture(scope="module")
def phone(browser, path):
    with visit(browser, path, PHONE, color_scheme="dark") as visited:
        yield visited


@pytest.fixture(params=["desktop", "phone"])
def visited(request):
    """The page in a window of either size."""
    return request.getfixturevalue(request.param)
