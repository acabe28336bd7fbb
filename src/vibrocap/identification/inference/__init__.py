"""Statistical inference about parameters at a minimum.

Given a prediction and its minimum, this room gives the covariance for errors that are correlated (`uncertainty`),
profile-likelihood intervals (`intervals`), a verdict for every parameter and which experiment would determine it
(`identifiability`), and what the errors show to be wrong with the data or the law (`residuals`, by a `diagnosis` on
arrays alone).
"""
