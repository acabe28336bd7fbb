"""Parameters of a friction law from measured force and motion, with intervals and with the parameters that the data
leave open.

This room is given records and a law. It says which parameters are free and predicts the force (`problem`), minimises
the squared errors (`search`), judges what the data determine (`inference`), writes it down (`fit_result`, `fit_report`)
and puts these together (`solution`) as fits: of the driven law and its steady curve (`fit`), of a contact that is
pulled through a spring (`spring_fit`). Each gives back a `Fit`; they differ in the prediction only. Bootstraps,
comparisons of laws and designs of experiments use fits (`experiments`). Imports go one way:

    experiments -> spring_fit -> fit -> solution -> fit_report -> fit_result -> inference -> search -> problem
"""
