"""Calibration: parameters of a case from a measured table of settled motions.

Given a system and a table (`table`), its rows are predicted by settled runs and fitted by least squares
(`table_model`); a column that does not fit is named (`column_doubt`). Given back: a `Calibration`, with intervals and
verdicts.
"""
