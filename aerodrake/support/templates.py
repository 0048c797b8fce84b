"""Templates of pages and drawings, in the folder `templates` of a package."""

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


def render_template(package: str, file: str, /, **variables: Any) -> str:
    """Renders a Jinja template and escapes all text.

    Args:
        package: Dotted name of the package.
        file: Name of the file in its folder `templates`.
        **variables: Variables of the template, all of them.
    """
    environment = Environment(
        loader=PackageLoader(package),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(file).render(**variables)
