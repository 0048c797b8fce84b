"""Mathematics as MathML with its font, written at build time: no script and no network."""

import base64
import io
import logging
from pathlib import Path

import ziamath
from docutils import nodes
from fontTools import subset
from latex2mathml.converter import convert
from sphinx.application import Sphinx

logging.getLogger("fontTools").setLevel(logging.WARNING)

FONT = Path(ziamath.__file__).parent / "fonts" / "STIXTwoMath-Regular.ttf"
STYLE = """@font-face { font-family: "STIX Two Math"; src: url(data:font/woff;base64,%s); }
math { font-family: "STIX Two Math", math; font-size: 1.1em; }
"""
ALPHABETS = (
    (0x20, 0x2FF),
    (0x370, 0x3FF),
    (0x2010, 0x2300),
    (0x1D434, 0x1D4CF),
    (0x1D6A4, 0x1D6FF),
)
"""Ranges of characters: Latin, Greek, operators, and their mathematical forms."""


def setup(app: Sphinx) -> dict[str, bool]:
    """Registers the renderer and the font."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_math_block, None))
    app.config.html_math_renderer = "mathml"
    app.add_css_file("math.css")
    app.connect("build-finished", write_style)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def visit_math(translator, node: nodes.math) -> None:
    """Writes a formula within a line."""
    translator.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def visit_math_block(translator, node: nodes.math_block) -> None:
    """Writes a displayed formula, which scrolls where it is too wide."""
    translator.body.append(f'<div class="formula">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def mathml(tex: str, display: str) -> str:
    """Returns a formula of the dialect that git hosts render, `inline` or as `block`."""
    formula = convert(tex.replace("{aligned}", "{align*}"), display=display)
    formula = formula.replace("<mover>", '<mover accent="true">')
    return formula.replace("<mo>&#x02016;", '<mo stretchy="false">&#x02016;')


def write_style(app: Sphinx, exception: Exception | None) -> None:
    """Writes the font's used alphabets into a style sheet, since browsers isolate local files."""
    if exception is None and app.builder.format == "html":
        options = subset.Options(flavor="woff", layout_features=["*"])
        font, file = subset.load_font(str(FONT), options), io.BytesIO()
        characters = [code for low, high in ALPHABETS for code in range(low, high + 1)]
        subsetter = subset.Subsetter(options)
        subsetter.populate(unicodes=characters)
        subsetter.subset(font)
        subset.save_font(font, file, options)
        text = STYLE % base64.b64encode(file.getvalue()).decode()
        Path(app.outdir, "_static", "math.css").write_text(text)
