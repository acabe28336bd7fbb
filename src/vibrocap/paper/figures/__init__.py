"""The figures of the paper as data: panels of curves from our own runs, which `report` draws.

`catalogue` lists them by key; each is a function that is given the runs.
"""
