"""Recorded expressions: a scalar function called once with symbols is known as a graph.

Given: functions of plain Python. Given back: their graph, with derivatives and values at points (`graph`), what is
known of them as functions of time (`forms`), and the balance of momentum from which the acceleration of a contact
follows (`balance`).
"""
