"""Mechanics from a description: a machine says what it is made of, and its equations of motion follow.

    formulas     recorded formulas and the straight-line programs that evaluate them
    sums         sums of products in one normal form, so that what cancels is gone
    quantities   a quantity along a motion: value, slopes, rate and curvature
    parts        masses, springs, dampers, drives, stops and contacts: what a machine is made of
    speeds       coordinates, and the speeds at which they move
    derivation   mass matrix and forces, hence accelerations, contacts, loads, energy and powers
    stops        guards and jumps of elastic and rigid stops
    pictures     bodies and joints for other programs, and what is drawn
    mirror       the numbers with which the equations are their own mirror image, or free of a place
    forms        all of this, derived once for all machines of a class that differ in numbers only

Everything is derived once for each form of a machine, as formulas of its numbers; numbers and recorded expressions are
put in afterwards. No array, no symbolic package and nothing of a method of solution here.
"""
