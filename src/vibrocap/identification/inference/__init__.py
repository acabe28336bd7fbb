"""Statistical inference about parameters at a minimum.

Given a prediction and its minimum, this room gives the covariance for errors that are correlated, profile-likelihood
intervals, and a verdict for every parameter: determined, bounded on one side, or not determined, and then which
experiment would determine it.
"""
