"""FMUs: a case as a file that Simulink, Dymola, OpenModelica, FMPy and other importers of FMI open.

Given a case, it gives the zip file (`fmu`): its variables and their description in XML (`description`), its sources
(the kernel in C, and `c/` around it) and, where there is a compiler, machine code.
"""
