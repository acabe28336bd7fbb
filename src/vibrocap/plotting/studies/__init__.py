"""Studies in pictures: maps over two axes, lines over one, dots for runs that do not lie on a grid.

Given a dataset, `view` says which measure is seen over which axes, `cells` as what each run is drawn (its value or why
it has none), and it or `maps` draws it; `study_figure` gives the figure.
"""
