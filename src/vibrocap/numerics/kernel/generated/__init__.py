"""The contract of generated code: what `source.py` writes for one system and the kernel modules call by these names.

Linking (`link.py`) puts the generated definitions, and the places of `memory_layout.py`, in the place of these. What
the equations give: functions (`equations`), what is known of them (`facts`), their guards (`branches`). Of the memory:
its `sizes` and `places`.
"""
