"""What a study is, before any of its runs: which values vary, what is measured, and all that decides its bits.

Given: axes, lists of cases or designs, measures and settings. Given back: a `Study`, checked, with its record and its
identity: the code, the parts of one's own and the machine that its numbers belong to.
"""
