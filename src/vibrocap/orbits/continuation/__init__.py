"""Branches of orbits followed over a parameter by pseudo-arclength, past folds and through changes of the itinerary.

Given a system, the path of a parameter and its range, `branch` gives the orbits along one branch, its special points
(folds, pitchforks, flips, Neimark-Sacker points, changes of the itinerary) and why it ends; `branches` gives all that
branch off from each other. Given a system (or two, to compare laws) and a measure, `crossing` gives every place where
the measure of the steady motion passes a value, with its error, and says where it equals the value or jumps over it.
"""
