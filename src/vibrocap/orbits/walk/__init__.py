"""One walk for every branch: what vanishes is followed by its arclength, past folds, to the end of its parameter.

A `Residual` says what shall vanish, in which range of a parameter, which tests tell its special points and where it
ceases to hold; the walk predicts along the tangent, corrects by Newton's method, chooses the step, brackets what
happens between two points and names the end. It knows no machine and no drive: orbits of driven systems, cycles that
return to a section and equilibria each bring a residual of their own.
"""
