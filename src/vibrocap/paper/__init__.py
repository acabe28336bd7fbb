"""The paper: its parameter sets, its figures from our own runs, its claims judged, its errata.

P. Liu, H. Yu and S. Cang, "Modelling and analysis of dynamic frictional interactions of vibro-driven capsule systems
with viscoelastic property", European Journal of Mechanics A/Solids (2019). Nothing in here is tuned: where a claim
fails, the nearest true statement stands beside it.
"""
