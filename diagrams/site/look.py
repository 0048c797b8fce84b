"""Checks the built site in Chromium: from the disk, offline, on a desktop and a phone.

    python diagrams/site/look.py build/site

Checks that no page is wider than its window, misses a file, or prints an error; that formulas have
a size; and that the search finds pages.
"""

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

DESKTOP, PHONE = (1440, 900), (390, 844)
SEARCHED = {
    "Kalman": "theory.html",
    "joints_outage": "faults.html",
    "make_station": "station.html",
    "MPC": "mpc.html",
    "K_B": "paper_comparison.html",
    "delay": "scenarios.html",
    "save": "tutorial.html",
}
"""Words and a page that each must lead to, among the first `RESULTS`."""
RESULTS = 6


def main(site: Path) -> int:
    """Prints the problems, and returns 1 if there are any."""
    command = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))))
    pages = sorted(site.rglob("*.html"))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=command, args=["--no-sandbox"])
        problems = [*visit(browser, pages, site), *search(browser, site)]
    for problem in problems:
        print(problem)
    print(f"{len(pages)} pages, {len(problems)} problems")
    return bool(problems) or len(pages) < 50


def visit(browser: Browser, files: list[Path], site: Path) -> Iterator[str]:
    """Yields the problems of the pages."""
    for width, height in (DESKTOP, PHONE):
        page = browser.new_page(viewport={"width": width, "height": height})
        problems = listen(page)
        for file in files:
            page.goto(file.as_uri())
            problems += layout(page, width)
            yield from (f"{file.relative_to(site)}, {width} px: {text}" for text in problems)
            problems.clear()
        page.close()


def listen(page: Page) -> list[str]:
    """Returns a list to which errors, missing files and requests to a network are appended."""
    problems: list[str] = []
    page.on("console", lambda message: message.type == "error" and problems.append(message.text))
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("requestfailed", lambda request: problems.append(f"missing {request.url}"))
    page.on("request", lambda request: is_local(request.url) or problems.append(request.url))
    return problems


def is_local(url: str) -> bool:
    return url.startswith(("file:", "data:"))


def layout(page: Page, width: int) -> Iterator[str]:
    """Yields elements that do not fit, or have no size."""
    wide = page.evaluate("document.documentElement.scrollWidth")
    if wide > width:
        yield f"{wide} px wide"
    sizes = "found => found.map(f => f.getBoundingClientRect().height).filter(h => !(h > 5)).length"
    for kind in ("article math", "article img", "article object"):
        if flat := page.locator(kind).evaluate_all(sizes):
            yield f"{flat} of '{kind}' without a size"


def search(browser: Browser, site: Path) -> Iterator[str]:
    """Yields the words that the search does not find."""
    for word, target in SEARCHED.items():
        page = browser.new_page()
        page.goto(f"{(site / 'search.html').as_uri()}?q={word}")
        page.wait_for_selector("#search-results li a")
        page.wait_for_function("document.querySelector('.search-summary')?.innerText.length > 10")
        links = page.locator("#search-results li a").evaluate_all("all => all.map(a => a.href)")
        links = links[:RESULTS]
        if not any(target in link for link in links):
            yield f"search for {word}: no {target} in {links}"
        page.close()


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).absolute()))
