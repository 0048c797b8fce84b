"""A page as a person opens it: from the disk, offline, in a headless Chromium."""

from __future__ import annotations

import io
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt
from playwright.sync_api import Browser, Locator, Page, sync_playwright

DESKTOP, PHONE = (1440, 900), (390, 844)

PATIENCE = 100
"""Looks at a replay, a fifth of a second apart, before it is considered blank."""

SWITCHES = (
    "--no-sandbox",  # CI is root.
    # WebGL without a graphics card.
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)


@contextmanager
def chromium() -> Iterator[Browser]:
    """The machine's own; where there is none, tests skip, but fail in CI."""
    command = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    if command is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)("there is no Chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=command, args=list(SWITCHES))
        yield browser
        browser.close()


@dataclass
class Visit:
    """An open page with its messages and requests since it was opened.

    Attributes:
        page: Of playwright.
        requests: Addresses, with that of the page itself first.
        messages: Messages of the console, and uncaught errors.
    """

    page: Page
    requests: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)

    def show(self, frame: Locator) -> np.ndarray:
        """Scrolls to a replay and waits for its vehicle, which has colours unlike all around it.

        Returns:
            (height, width, 3) what is seen of it, in [0, 1].
        """
        frame.scroll_into_view_if_needed()
        frame.content_frame.locator("canvas").first.wait_for()
        for _ in range(PATIENCE):
            seen = pixels(frame)
            if np.ptp(seen, axis=2).max() > 0.5:
                break
            self.page.wait_for_timeout(200)
        # Out of sight, it need not be drawn all the while.
        self.page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        return seen


def assert_silent(visited: Visit, path: Path, screenshot: Path) -> None:
    """Asserts that a page with a replay prints no messages and requests only itself.

    The replay plays, too: it is unpacked once it is near.
    """
    visited.show(visited.page.locator("#replay"))
    visited.page.screenshot(path=screenshot, full_page=True)
    assert visited.messages == []
    requested = [url for url in visited.requests if not url.startswith(("data:", "blob:"))]
    assert requested == [path.as_uri()]


def assert_no_wider_than_its_window(page: Page) -> None:
    width = page.viewport_size["width"]
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.evaluate("scrollTo(1000, 0)")
    assert page.evaluate("scrollX") == 0


def assert_no_text_is_cut(page: Page) -> None:
    """Asserts that the texts of a picture are within it, to a pixel."""
    over = page.locator("figure svg text").evaluate_all(
        """texts => texts.filter(text => {
            const [inner, outer] = [text, text.ownerSVGElement].map(e => e.getBoundingClientRect());
            return inner.right > outer.right + 1 || inner.left < outer.left - 1;
        }).map(text => text.textContent)"""
    )
    assert not over, over


def assert_replay_draws(visited: Visit) -> None:
    """Sky and ground are shades of grey; propellers, arm and path are orange."""
    seen = visited.show(visited.page.locator("#replay"))
    assert min(seen.shape[:2]) > 300
    assert np.count_nonzero((seen[..., 0] > 0.7) & (seen[..., 2] < 0.35)) > 100
    assert len(np.unique(seen.reshape(-1, 3), axis=0)) > 1000


def assert_ids_are_found(page: Page, path: Path) -> None:
    """Ids are unique, and what refers to one finds it."""
    ids = page.locator("[id]").evaluate_all("all => all.map(element => element.id)")
    assert len(ids) == len(set(ids)) > 100
    text = path.read_text()
    assert set(re.findall(r'(?:href|aria-labelledby)="#?([^"]+)"', text)) - {"data:,"} <= set(ids)
    assert set(re.findall(r"url\(#([^)]+)\)", text)) <= set(ids)


@contextmanager
def visit(browser: Browser, path: Path, size: tuple[int, int] = DESKTOP, **how) -> Iterator[Visit]:
    """Opens a page in a window of `size` px, without a network."""
    width, height = size
    context = browser.new_context(
        viewport={"width": width, "height": height}, offline=True, reduced_motion="reduce", **how
    )
    page = context.new_page()
    visited = Visit(page)
    page.on("request", lambda request: visited.requests.append(request.url))
    page.on("console", lambda message: visited.messages.append(message.text))
    page.on("pageerror", lambda error: visited.messages.append(str(error)))
    page.goto(path.absolute().as_uri())
    yield visited
    context.close()


def pixels(place: Locator) -> np.ndarray:
    """(height, width, 3) of what is seen of an element, in [0, 1]."""
    return plt.imread(io.BytesIO(place.screenshot()))[..., :3]
