"""Steady motions: periodic modulo the drift, with their stability, branches and basins."""
