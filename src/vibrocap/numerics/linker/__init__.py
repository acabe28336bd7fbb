"""Joins a kernel's parts to one text, of which machine code or plain Python is made.

Given: generated code and a recipe (`recipes`), which says of what modules of `kernel/` a kernel consists and which of
them fills each slot. Given back: the text (`link`), after it was checked that every slot is filled once and as its
interface says, and that no name is defined twice or is missing (`checks`).
"""
