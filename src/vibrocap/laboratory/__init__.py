"""What a friction law does: canonical tests, reports on passivity and stiffness, the price of smoothing it."""
