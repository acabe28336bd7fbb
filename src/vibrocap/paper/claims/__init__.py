"""The claims of the paper, each judged by a computation.

A claim is a function that is given the runs and a tolerance and gives back what it found; the files are the chapters of
the paper. `chapters` lists them in the order of the paper.
"""
