"""What fits are used for: comparing and matching laws, bootstrapping and designing experiments.

Given records, laws or a finished `Fit`, each file answers one question: which law predicts best, how far the parameters
scatter, which motion would determine them, and how close one law comes to another.
"""
