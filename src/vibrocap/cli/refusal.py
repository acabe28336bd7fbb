"""Refusals: input that a command cannot use, named by its options."""

from collections.abc import Iterable, Mapping

from vibrocap.arguments import Complaint


class Refusal(ValueError):
    """Input that cannot be used: each complaint names an option and a correct value. The exit code is 2."""

    def __init__(self, *complaints: str):
        super().__init__("\n".join(complaints))
        self.complaints = complaints


def by_option(complaints: Iterable[str], options: Mapping[str, str]) -> list[str]:
    """The same complaints, with options in place of the fields that they set; options: their names by field."""
    return [
        complaint.about(options[complaint.field])
        if isinstance(complaint, Complaint) and complaint.field in options
        else complaint
        for complaint in complaints
    ]
