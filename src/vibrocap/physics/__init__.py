"""The physics: machines, friction laws and drives, one family per file, and the system that they make together.

Given the numbers of a part, checked where they are declared with their symbol and meaning, it gives its equations as
plain scalar functions (`elementary`), which compute with floats and record with symbols. `system` is the one place
where the equations of the three parts meet; `catalogue` finds the parts by looking into their folders, `dimensions`
leads to SI and back, and `symbols` writes the page of all names. No array, no compiler and no method of solution here.
"""
