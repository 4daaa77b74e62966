"""The command line of geomhw: one module a command; parsing, calling and writing, no mathematics."""
