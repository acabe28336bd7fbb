"""Joins a kernel's parts to one text, of which machine code or plain Python is made.

Given: generated code and a recipe (`recipes`), which says of what modules of `kernel/` a kernel consists. Given back:
the text (`link`), with what `kernel/hook.py` says where no module answers. Before it runs it is checked that
functions have the arguments of their hooks, and that no name is defined twice or is missing.
"""
