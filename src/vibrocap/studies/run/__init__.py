"""Who computes the tiles of a study: processes of this machine or the workers of a cluster.

Given: a study and the folder of its store. Given back: counts of how runs ended; who computes a tile stores it.
"""
