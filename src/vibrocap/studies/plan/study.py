"""A study: which runs of which system, what is measured on them and how; and what makes it this study and no other."""

import dataclasses
import functools
import hashlib
import json
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.case.case import Case, CaseError, case_from_text, case_text
from vibrocap.measures.measure import Measure
from vibrocap.studies.plan.axes import Grid
from vibrocap.studies.plan.cases import CaseList
from vibrocap.studies.plan.code_version import code_version
from vibrocap.studies.plan.designs import Drawn
from vibrocap.studies.plan.own_parts import function_fingerprint, own_parts, part_fingerprint
from vibrocap.studies.plan.runs import Runs

FORMAT = "vibrocap study, format 2"
PLANS: dict[str, type[Runs]] = {plan.kind: plan for plan in (Grid, CaseList, Drawn)}


@dataclasses.dataclass(frozen=True)
class Study:
    """Everything on which the results of a study depend, and nothing else; small, and it can be sent to other machines.

    case: the system on which the plan's values are put, where its runs start, and how they are run
    plan: the runs
    measures: names of what is measured, or measures of one's own
    window, settle, device, extrapolate: how, as `ensemble` takes them; a card gives other bits than a processor
    code: with what the results are made, by name, see `code_version`; as it is here unless given

    How it is carried out (threads, workers, tiles, their order) is no part of it: results do not depend on that.
    """

    case: Case
    plan: Runs
    measures: tuple[str | Measure, ...]
    window: int = 10
    settle: float | None = None
    code: Mapping[str, str] = dataclasses.field(default_factory=dict)
    device: str = "cpu"
    extrapolate: bool = False

    def __post_init__(self):
        if not self.code:
            object.__setattr__(self, "code", code_of(self.plan))

    @property
    def settings(self) -> dict[str, Any]:
        """How the runs are made, as `ensemble` takes it."""
        return {
            **self.case.run,
            "window": self.window,
            "settle": self.settle,
            **self._extrapolates,
            "device": self.device,
        }

    @property
    def _extrapolates(self) -> dict[str, bool]:
        """Nothing where it means nothing."""
        return {} if self.settle is None else {"extrapolate": self.extrapolate}

    def record(self) -> dict[str, Any]:
        """The study as JSON can hold it: enough to run it again (with measures and parts of one's own given again)."""
        parts = {what: part_fingerprint(part) for what, part in self.own_parts.items()}
        measures = [_measure_record(measure) for measure in self.measures]
        how = {"window": self.window, "settle": self.settle, **self._extrapolates}
        how |= {"device": self.device, "code": dict(self.code)}
        what = {"case": case_text(self.case), "plan": self.plan.record(), "measures": measures}
        return what | how | ({"parts": parts} if parts else {})

    @functools.cached_property
    def own_parts(self) -> dict[str, type]:
        """Parts that are not of this package, by what they are in the study, as in {"friction.law = own": Own}."""
        return own_parts(self.case, self.plan.record())

    @classmethod
    def from_record(cls, record: Mapping[str, Any], measures: Iterable[Measure] = ()) -> "Study":
        """The study of a record; measures: those of one's own, which a record does not hold as functions.

        Raises CaseError where one of them is missing or is another than that of the record.
        """
        own = {measure.name: measure for measure in measures}
        known, complaints = [], []
        for entry in record["measures"]:
            if isinstance(entry, str):
                known.append(entry)
            elif entry["name"] in own and _measure_record(own[entry["name"]]) == entry:
                known.append(own[entry["name"]])
            else:
                complaints.append(f"measures: {entry['name']!r} is a measure of one's own; give it, as it was")
        if complaints:
            raise CaseError(complaints, "the study")
        plan = PLANS[record["plan"]["kind"]].from_record(record["plan"])
        case = case_from_text(record["case"], "the case of the study")
        how = (
            record["window"],
            record["settle"],
            dict(record["code"]),
            record["device"],
            record.get("extrapolate", False),
        )
        return cls(case, plan, tuple(known), *how)

    @functools.cached_property
    def identity(self) -> str:
        """SHA-256 of all that makes this study, the order of its measures aside."""
        record = self.record()
        record |= {"measures": sorted(record["measures"], key=str), "format": FORMAT}
        text = json.dumps(record, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()


def code_of(plan: Runs) -> dict[str, str]:
    """With what the results of a plan's runs would be made here."""
    return code_version(drawn=isinstance(plan, Drawn) and plan.design.kind != "random")


def _measure_record(measure: str | Measure) -> Any:
    """A name, or what identifies a measure of one's own."""
    if isinstance(measure, str):
        return measure
    how = measure.how
    found = {"name": measure.name, "meaning": measure.meaning, "unit": measure.unit, "how": type(how).__name__}
    found |= {"si_unit": measure.si_unit} if measure.si_unit != "1" else {}
    found |= {name: getattr(how, name) for name in ("kind", "of") if hasattr(how, name)}
    found |= {"of": list(found["of"])} if "of" in found else {}
    return found | {"function": function_fingerprint(getattr(how, "function", how))}
