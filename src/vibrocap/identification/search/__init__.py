"""Least squares within bounds, from many starts.

Given a prediction and starts, `descent` gives the minimum near one of them and `search` the best of several; the loss
says how errors count.
"""
