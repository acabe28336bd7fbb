"""Parameters of a friction law from measured force and motion, with intervals and with the parameters that the data
leave open.

This room is given records and a law. It says which parameters are free and predicts the force (`problem`), minimises
the squared errors (`search`), judges what the data determine (`inference`), writes it down (`result`) and puts these
together as fits (`fitting`). Bootstraps, comparisons of laws and designs of experiments use fits (`experiments`).
Imports go one way:

    experiments -> fitting -> result -> inference -> search -> problem
"""
