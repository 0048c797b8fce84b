"""Predictive kinematic control of aerial manipulators as a Drake diagram.

`__init__.pyi` lists the public names. They are imported at their first use, since Drake, torch and
matplotlib take seconds.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
