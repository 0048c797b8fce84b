"""Configuration of the documentation: python -m sphinx -W -c diagrams/site diagrams build/site.

The sources are the pages of `diagrams/`, which are readable on a plain git host too; the pages
of the API reference are made at each build from the docstrings.
"""

import os
import sys
from pathlib import Path

os.environ["NUMBA_DISABLE_JIT"] = "1"  # Compiled functions stay functions, with signatures.
HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from aerodrake import __doc__ as summary  # noqa: E402

project = "aerodrake"
author = "the aerodrake maintainers"
root_doc = "index"
exclude_patterns = ["site", "graphs/*.mmd"]
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.graphviz",
    "sphinx.ext.napoleon",
    "api_pages",
    "docstrings",
    "sources",
    "mathml",
    "scenario_keys",
]

myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
suppress_warnings = ["ref.python"]  # `name` of two objects: it is not linked.

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
napoleon_use_ivar = True
toc_object_entries_show_parents = "hide"
default_role = "py:obj"
graphviz_output_format = "svg"

html_theme = "furo"
html_title = "aerodrake"
html_short_title = summary.splitlines()[0]
html_static_path = ["static"]
html_css_files = ["site.css"]
html_domain_indices = False  # The reference lists the modules.
html_copy_source = False
html_show_copyright = html_show_sphinx = False
html_search_scorer = str(HERE / "search_scores.js")
html_show_search_summary = False  # It would fetch pages, which a browser refuses for files.
