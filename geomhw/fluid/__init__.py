"""Incompressible flow on a surface: schemes that take a state a step further."""
