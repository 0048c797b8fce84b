"""Adapts the pages, which are written for a git host, to the site."""

import re
import shutil
from pathlib import Path

from sphinx.application import Sphinx

COPIES = {"index": "README.md", "changelog": "CHANGELOG.md"}
"""Pages that begin with a file at the top of the repository."""

SYSTEMS = "\n```{toctree}\n:hidden:\n:glob:\n\ngraphs/*\n```\n"
"""Pages of the systems in the navigation, below the gallery."""

MERMAID = re.compile(r"^```mermaid(\n.*?^)```$", re.MULTILINE | re.DOTALL)
CODE_LINK = re.compile(r"\]\((?:\.\./)?aerodrake/([\w/]+?)(?:\.py|/)?\)")
PAGES_OF_CODE = {"scenario/sections": "scenario_keys", "cli": "command_line"}
"""Pages of the site that are made from a file of the package."""


def setup(app: Sphinx) -> dict[str, bool]:
    """Connects the adaptations."""
    app.connect("source-read", adapt)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def adapt(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replaces the text of a page.

    - The home page and the changelog get their text, with links from the folder of the pages.
    - A link to a file of the package leads to its page in the reference.
    - A Mermaid graph, which needs a script, is replaced by the `.dot` file beside the page; it
      stays text if this machine has no Graphviz.
    """
    if name := COPIES.get(docname):
        text = Path(app.srcdir).parent.joinpath(name).read_text()
        source[0] = text.replace("](diagrams/", "](") + "\n" + source[0]
    source[0] = re.sub(r"\]\((\.\./)?CHANGELOG.md\)", "](changelog.md)", source[0])
    source[0] = source[0].replace("](../README.md", "](index.md")
    if docname == "README":
        source[0] += SYSTEMS
    folder = "../" * docname.count("/") + "api/"
    source[0] = CODE_LINK.sub(lambda match: f"]({folder}{reference_page(match[1])})", source[0])
    dot = Path(app.srcdir, docname).with_suffix(".dot")
    if dot.exists():
        graph = f"```{{graphviz}} {dot.name}\n```" if shutil.which("dot") else r"```text\1```"
        source[0] = MERMAID.sub(graph, source[0])


def reference_page(path: str) -> str:
    """Returns the page of a path below `aerodrake/`, with an anchor for a module of a folder."""
    if page := PAGES_OF_CODE.get(path):
        return f"{page}.md"
    *folders, last = path.split("/")
    if Path(__file__).parents[2].joinpath("aerodrake", path).is_dir():
        return f"{path.replace('/', '.')}.md"
    return f"{'.'.join(folders)}.md#{last}" if folders else f"{last}.md"
