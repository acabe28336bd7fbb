"""Diagnosis: which faults of the measurement or of the law the errors of a fit show, on arrays alone.

`diagnosis` looks first for faults that the columns show by themselves (`measurement_faults`: saturation, quantisation,
outliers), then lets causes compete that add a known pattern to the force (`patterns`, `timing`), each tested by
`pattern_test`.
"""
