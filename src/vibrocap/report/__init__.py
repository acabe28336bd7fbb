"""The report on the paper: its figures from our own runs, its claims with their verdicts, one page of HTML.

Given a folder, `reproduce` runs what `paper` describes, draws the figures, judges the claims and writes all of it down:
figures with their data, claims as JSON and CSV, and a page that needs nothing else. It gives back where these lie.
"""
