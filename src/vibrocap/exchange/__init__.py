"""Exchange: a case as what other programs run, with its exact contact.

Given a case, it gives files: C sources (`c_library`), of the same kernel as every motion of the package. And objects
that are moved on from outside, as those sources are: a motion (`stepper`), many (`stepper_array`). What they share,
what crosses the border, is `stepped_case`.
"""
