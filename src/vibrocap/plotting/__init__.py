"""Pictures: the only room that draws.

Given a result (a motion, a study, branches, basins, a fit, a sheet of canonical tests, a measured record), a
`..._figure` gives its figure, which `save` writes into a file (.png, .svg, .pdf); a `draw_...` draws into axes
that it is given. All share one `style`, give the same bytes for the same result, and say nothing by colour alone. They
know results, not how these were made.
"""
