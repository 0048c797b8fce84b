"""The loop's own LeafSystems: ports, rates and state."""

from pydrake.systems.framework import LeafSystem

# After every unrestricted update Drake asks each system for its witness functions, and pybind11
# whether Python has any. It remembers that it has none only where it finds a method of C++;
# LeafSystem has none of this name, and to find that out by an exception each time takes 1 us.
LeafSystem.DoGetWitnessFunctions = LeafSystem.DoCalcTimeDerivatives
