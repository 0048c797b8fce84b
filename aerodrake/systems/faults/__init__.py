"""Systems that inject faults; a diagram has them only if its scenario does."""
