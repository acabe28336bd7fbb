"""Cases: a system and how to run it, in a TOML file and in Python in the same words.

`read_case` is given a file and gives a `Case`, or a `CaseError` with every complaint at once, each with the path of its
field and what would be right. `case_text` is the way back, with every parameter written out, so that a stored case
reads back equal. `Case.simulate` is its motion.
"""

from vibrocap.case.case import Case, CaseError, case_from_dict, case_from_text, case_text, read_case, save_case

__all__ = ["Case", "CaseError", "case_from_dict", "case_from_text", "case_text", "read_case", "save_case"]
