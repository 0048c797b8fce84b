"""Pages that need nothing but themselves: templates, and what they hold."""

from __future__ import annotations

import base64
import gzip
from importlib.metadata import version
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from pydrake.systems.framework import Diagram

from aerodrake.reports.loop_chart import loop_chart


def render(template: str, closed_loop: Diagram, replay: str, **content: Any) -> str:
    """Fills a template; what is text is escaped.

    Args:
        template: Its file in `aerodrake/reports/templates`.
        closed_loop: Which the page has a chart of.
        replay: A page of its own, as `replay_page` makes it; empty if there is none.
        content: What else the template asks for.
    """
    environment = Environment(
        loader=PackageLoader("aerodrake.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(
        chart=loop_chart(closed_loop),
        replay=_packed(replay) if replay else "",
        version=version("aerodrake"),
        **content,
    )


def _packed(text: str) -> str:
    """Compressed, in letters that mean nothing to HTML."""
    return base64.b64encode(gzip.compress(text.encode(), compresslevel=6, mtime=0)).decode()
