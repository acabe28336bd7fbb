"""What a fit minimises: samples of records, free parameters as coordinates, and the predicted force.

Given records and a law, `samples` gives the columns that a fit uses, `parametrisation` the free parameters with bounds
and a start, and a prediction the error of every sample as a function of the coordinates. The force is that of the law
driven by the measured motion, of its steady curve, or of a contact that is pulled through a spring.
"""
