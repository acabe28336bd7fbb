"""Machines, one per file."""
