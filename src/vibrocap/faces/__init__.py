"""Command line, plots, exports and reports."""
