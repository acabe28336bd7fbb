"""The text of a kernel as a typed tree (`nodes.py`), which every target is written from.

`Program` (`program.py`) is given a kernel's parts and asked for functions of it; it knows no target but for lanes and
which functions of `math` a target has itself.
"""
