"""Size and loading time of a report page; not part of the default test run."""

import pytest

from aerodrake.cli import main
from tests.browser import DESKTOP, PHONE, chromium, visit

MAX_BYTES = 6e6
MAX_MS = 2000.0


@pytest.mark.parametrize(
    "command",
    [("run", "clover"), ("run", "clover_realistic"), ("compare", "clover")],
    ids=" ".join,
)
def test_a_page_is_small_and_opens_quickly(command, tmp_path):
    assert main([*command, "--quiet", "--out", str(tmp_path / "out")]) == 0
    path = tmp_path / "out" / "report.html"
    size = path.stat().st_size
    assert size < MAX_BYTES
    with chromium() as browser:
        for window in (DESKTOP, PHONE):
            with visit(browser, path, window) as visited:
                parsed, loaded = visited.page.evaluate(
                    "(({ domContentLoadedEventEnd, loadEventEnd }) =>"
                    " [domContentLoadedEventEnd, loadEventEnd])"
                    "(performance.getEntriesByType('navigation')[0])"
                )
            print(f"\n{size / 1e6:.2f} MB, {window[0]} px: parsed {parsed:.0f} ms, {loaded:.0f} ms")
            assert loaded < MAX_MS
