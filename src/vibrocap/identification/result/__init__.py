"""The record of a fit, `Fit`: parameters with intervals, errors by record, text, JSON and a section of a case file.

Given a minimum with its intervals, `finished_fit` gives the record. A `Fit` writes itself to a folder, in the units of
the data or in those of a case.
"""
