"""The page: template, styles, scripts and data in one file.

Its policy lets the browser run these scripts and no others, make code of no text, and ask no address for anything.
Scripts are shortened by what only a reader of their source needs: comments, and spaces that part nothing.
"""

import base64
import hashlib
import importlib.resources
import json
import re
from collections.abc import Iterable, Mapping
from html import escape
from importlib.metadata import version
from string import Template
from typing import Any

from vibrocap.physics.symbols import GREEK

# In the order in which they use each other; the worker's come to it as text.
WORKER = ("worker/engine.js", "worker/dense.js", "worker/worker.js")
SCRIPTS = (
    *("charts.js", "scene.js", "model.js", "panels.js", "share.js", "maps.js"),
    *("controls.js", "readouts.js", "fields.js", "print.js", "main.js", "sharing.js"),
)


def source(name: str) -> str:
    """A file of `web/`."""
    return importlib.resources.files("vibrocap.lab").joinpath("web", *name.split("/")).read_text(encoding="utf-8")


def script(names: tuple[str, ...]) -> str:
    """Scripts joined and shortened."""
    return shortened("\n".join(source(name) for name in names)).replace("</script", "<\\/script")


def functions(forms: Iterable[Mapping[str, Any]]) -> tuple[str, str]:
    """The functions that are written for each form, as scripts for the page and for its worker.

    RULES[form](p, f): the first rule that is broken; MIRRORED[form](p, odd): whether a motion has a mirror-image
    solution; READERS[form](r, T, h, m): the measures of a result by name; CUTS[form](p): into how many equal parts the
    corners of a drive cut its period
    """
    rows = []
    for form in forms:
        measures = ",".join(f"{measure['name']}:{measure['read']}" for measure in form.get("measures", ()))
        parts = form["corners"]["parts"] if form["corners"] else 0
        own = f"(p,f)=>{form['rules']}||null", f"(p,odd)=>{form['mirrored']}"
        rows.append((*own, f"(r,T,h,m)=>({{{measures}}})", f"(p)=>{parts}"))
    rules, mirrored, readers, cut = (f"[{','.join(column)}]" for column in zip(*rows, strict=True))
    return f"const RULES={rules};\n", f"const MIRRORED={mirrored},READERS={readers},CUTS={cut};\n"


def _policy(scripts: str, styles: str) -> str:
    """What the browser is to allow the page, as a Content Security Policy (level 3)."""
    sums = (hashlib.sha256(text.encode()).digest() for text in (scripts, styles))
    script, style = (base64.b64encode(checksum).decode("ascii") for checksum in sums)
    allowed = {
        "default-src": "'none'",
        "script-src": f"'sha256-{script}' 'wasm-unsafe-eval'",
        "style-src": f"'sha256-{style}'",
        "worker-src": "blob:",
        "img-src": "blob: data:",
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in allowed.items())


def page(data: Mapping[str, Any], title: str = "vibrocap lab") -> str:
    """The HTML of a page with the data of a `bundle`."""
    own, workers = functions(data["forms"])
    measures: dict[str, dict[str, Any]] = {}  # by their text: most are those of all forms, and stand once
    forms = []
    for form in data["forms"]:
        shown = [{name: value for name, value in measure.items() if name != "read"} for measure in form["measures"]]
        measures |= {json.dumps(record): record for record in shown}
        numbers = [list(measures).index(json.dumps(record)) for record in shown]
        forms.append({name: value for name, value in form.items() if name != "rules"} | {"measures": numbers})
    data = {**data, "forms": forms, "measures": list(measures.values())}
    letters = f"const GREEK={json.dumps(GREEK, ensure_ascii=False)};\n"
    scripts, styles = f'"use strict";\n{letters}{own}{script(SCRIPTS)}', re.sub(r"\n\s*", "\n", source("lab.css"))
    content = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return Template(source("lab.html")).substitute(
        title=escape(title),
        policy=_policy(scripts, styles),
        styles=styles,
        version=version("vibrocap"),
        data=content,
        worker=workers + script(WORKER),
        scripts=scripts,
    )


# What is left as it is: texts, and what is matched by a slash after a sign that begins a value.
TEXT = re.compile(
    r""""(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|(?<=[(,=:!&|?;{}\[])\s*/(?![/*])(?:[^/\\\n\[]|\\.|\[(?:[^\]\\\n]|\\.)*\])+/[a-z]*"""
)
COMMENT = re.compile(r"\s*//[^\n]*|/\*.*?\*/", re.DOTALL)
WORDS = re.compile(r"[\w$]+")
SPACES = re.compile(r"\s+")
WORD = re.compile(r"[\w$]")
GOES_ON = set("{};,(=?:&|[")  # signs after which the end of a line ends no statement


def shortened(script: str) -> str:
    """A script that does the same, of one whose statements all end with a semicolon or a brace."""
    return _until(script, 0, "")[0].strip()


def _until(script: str, at: int, end: str) -> tuple[str, int]:
    """(the script from a place to a closing brace or to its end, the place behind that)."""
    out: list[str] = []
    depth = 0
    while at < len(script):
        letter = script[at]
        if letter == "`":
            text, at = _template(script, at)
            out.append(text)
        elif match := TEXT.match(script, at) or WORDS.match(script, at):
            out.append(match[0].lstrip())
            at = match.end()
        elif match := COMMENT.match(script, at):
            at = match.end()
        elif match := SPACES.match(script, at):
            at = match.end()
            before = out[-1][-1] if out else "{"
            after = script[at] if at < len(script) else "}"
            if "\n" in match[0] and before not in GOES_ON and after not in "})]?:.,&|":
                out.append("\n")
            elif (WORD.match(before) and WORD.match(after)) or (before in "+-" and after in "+-"):
                out.append(" ")
        else:
            depth += {"{": 1, "}": -1}.get(letter, 0)
            if depth < 0 and end:
                return "".join(out), at + 1
            out.append(letter)
            at += 1
    return "".join(out), at


def _template(script: str, at: int) -> tuple[str, int]:
    """(a text between backticks, the place behind it): the expressions in it are shortened, the text is not."""
    out, at = ["`"], at + 1
    while script[at] != "`":
        if script.startswith("${", at):
            inner, at = _until(script, at + 2, "}")
            out.append(f"${{{inner}}}")
            continue
        width = 2 if script[at] == "\\" else 1
        out.append(script[at : at + width])
        at += width
    return "".join([*out, "`"]), at + 1
