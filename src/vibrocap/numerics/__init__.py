"""Motions of recorded equations, computed: handed equations, it knows no capsule.

Equations are recorded (`expressions/`), written as the text of their series, rates and Jacobian (`codegen/`), joined
with the sources of the loop (`kernel/`) to one text (`linker`), which becomes machine code (`compiler/`) and is run
for one motion, many, or a law under an imposed motion (`run/`).
"""
