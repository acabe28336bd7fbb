"""Recorded expressions: a scalar function called once with symbols is known as a graph.

Given: functions of plain Python. Given back: their graph, with derivatives and values at points (`graph`), what is
known of them as functions of time (`structure`), and the equations of a system (`equations`), of motion also before
they are solved.
"""
