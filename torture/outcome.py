"""What an attack found."""

import dataclasses


@dataclasses.dataclass
class Outcome:
    """So many trials, and a line for each that broke a promise; `words` say more of the trials."""

    attack: str
    trials: int = 0
    faults: list[str] = dataclasses.field(default_factory=list)
    words: str = ""

    def check(self, good: bool, fault: str) -> None:
        """Count a trial."""
        self.trials += 1
        if not good:
            self.faults.append(fault)
