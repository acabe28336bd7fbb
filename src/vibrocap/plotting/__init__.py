"""Pictures: the only room that draws.

Given a result (a motion, a study, branches, basins, a fit, a sheet of canonical tests, a measured record) and a path, a
`plot_...` function draws it into a .png, .svg or .pdf and gives back the path; a `..._figure` gives the figure, a
`draw_...` draws into axes that it is given. All share one `style`, write the same bytes for the same result, and say
nothing by colour alone. They know results, not how these were made.
"""
