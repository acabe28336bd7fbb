"""How far a step may go, and the state at its end: Taylor series, stabilised series, an implicit method for stiff laws.

Given: the series of the present step in memory. Given back: a length to which it can be trusted, or the series of an
implicit step. Which method is asked is decided in `explicit` (laws that stick) or `method_choice` (laws that may be
stiff); `resolved` refuses a step that may not see all that the law holds; `loop/side_by_side` decides both for
all lanes at once. Functions that choose by `where`, `&` and `|`, not by `if`, `and` and `or`, are of one lane or, given
the places of all in its stead, of all.
"""
