"""What fits are used for: comparing and matching laws, bootstrapping, designing experiments and testing them.

Given records, laws or a finished `Fit`, each file answers one question: which law predicts best, how far the parameters
scatter, which motion would determine them, how close one law comes to another, and whether fits of simulated
experiments give back the truth.
"""
