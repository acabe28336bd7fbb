"""Measured records: what was measured, checked, with its units; read from files, prepared for a fit."""
