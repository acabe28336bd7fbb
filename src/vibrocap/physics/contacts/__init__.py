"""Machines that rub at several contacts: seen by all else as machines on their first one.

Given: a machine, the laws of its further contacts and its environment. Given back: a machine whose states, rates and
guards hold those contacts too. Each is decided by itself (`machine_on_contacts.py`) unless they act on one another
(`coupled_contacts.py`), be it only that their distances are imposed (`imposed_distances.py`).
"""
