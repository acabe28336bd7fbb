"""Differences of two studies, and of what made their results, in words: why one cannot continue the other."""

import tomllib
from collections.abc import Mapping
from typing import Any

from vibrocap.measures.standard import LOAD_WATCH

Said = dict[str, tuple[str, Any]]  # name: (a short text, what is to be equal)


def differences(stored: Mapping[str, Any], asked: Mapping[str, Any]) -> list[str]:
    """In what the records of two studies differ, one line each."""
    here, there = _described(stored), _described(asked)
    lines = []
    for what in {**here, **there}:
        if here.get(what, ("", None))[1] != there.get(what, ("", None))[1]:
            texts = [side[what][0] if what in side else "none" for side in (here, there)]
            further = ", not the same" if texts[0] == texts[1] else ""
            lines.append(f"{what}: stored {texts[0]}, asked {texts[1]}{further}")
    return lines


def _described(record: Mapping[str, Any]) -> Said:
    described: Said = {}
    for section, entries in tomllib.loads(record["case"]).items():
        for key, value in entries.items() if isinstance(entries, dict) else ():
            described[key if section == "run" else f"{section}.{key}"] = (str(value), value)
    described |= {name: (str(record[name]), record[name]) for name in ("window", "settle", "device")}
    described["extrapolate"] = (str(extrapolate := record.get("extrapolate", False)), extrapolate)
    names = [measure if isinstance(measure, str) else measure["name"] for measure in record["measures"]]
    asked = [measure for measure in record["measures"] if measure != LOAD_WATCH]
    described["measures"] = (", ".join(name for name in names if name != LOAD_WATCH), sorted(map(str, asked)))
    described["watch of the load"] = ("on", True) if LOAD_WATCH in names else ("off", False)
    described |= _plan(record["plan"])
    for what, digest in record.get("parts", {}).items():
        described[f"the code of {what}"] = (digest[:12], digest)
    return described


def code_differences(stored: Mapping[str, str], here: Mapping[str, str]) -> list[str]:
    """In what two codes, and what they run with, differ, one line each."""
    keys = ("version", "sources")
    lines = []
    if any(stored.get(key) != here.get(key) for key in keys):
        texts = [f"vibrocap {code['version']} with sources {code['sources'][:12]}" for code in (stored, here)]
        lines.append(f"code: stored {texts[0]}, here {texts[1]}")
    for key in dict.fromkeys((*stored, *here)):
        then, now = stored.get(key, "unknown"), here.get(key, "unknown")
        if key in keys or then == now:
            continue
        if key == "features":  # only those that one of them lacks
            old, new = {*then.split()}, {*now.split()}
            then, now = " ".join(sorted(old - new)), " ".join(sorted(new - old))
        lines.append(f"{key}: stored {then or 'fewer'}, here {now or 'fewer'}")
    return lines


def _plan(plan: Mapping[str, Any]) -> Said:
    varied = plan.get("axes") or plan.get("ranges") or plan.get("columns") or []
    names = [entry["path"] for entry in varied]
    entries: Said = {"plan": (f"{plan['kind']} of {', '.join(names)}", (plan["kind"], names))}
    for name, value in plan.get("design", {}).items():
        entries[f"design.{name}"] = (str(value), value)
    for entry in varied:
        if "values" in entry:
            values = entry["values"]
            few = f"{values[0]} ... {values[-1]}" if len(values) > 3 else ", ".join(map(str, values))
            entries[f"values of {entry['path']}"] = (f"{len(values)} ({few})", values)
        else:
            scale = "log:" if entry["logarithmic"] else ""
            entries[f"range of {entry['path']}"] = (f"{scale}{entry['low']}:{entry['high']}", entry)
    return entries
