"""The laboratory: what a friction law does, apart from any machine.

Given a law, it gives back the results of the canonical tests (`loops`, `pulled_block`, all of them in `test_sheet`),
the force that answers an imposed motion (`driven`), whether the law can create energy, with a cycle that does
(`passivity`), the time scales that it brings into a system (`stiffness`), and the error that a smoothed contact makes
(`regularisation`).
"""
