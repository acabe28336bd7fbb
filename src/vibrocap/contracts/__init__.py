"""Contracts of laws, machines and drives, as checks that describe each fault.

Given a part of one's own, `check_part` gives back a report, a line per clause of its contract. The tests of this
package hold its own parts to the same clauses. A clause is a function from a part to what is wrong, or None; it samples
the part's scalar functions and its recorded equations.
"""
