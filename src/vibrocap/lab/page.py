"""The page: template, styles, scripts and data in one file."""

import importlib.resources
import json
import re
from collections.abc import Mapping
from html import escape
from importlib.metadata import version
from string import Template
from typing import Any

from vibrocap.lab.shortened import shortened

# In the order in which they use each other; the worker's come to it as text.
WORKER = ("worker/engine.js", "worker/dense.js", "worker/worker.js")
SCRIPTS = (
    *("charts.js", "scene.js", "model.js", "panels.js", "share.js", "maps.js"),
    *("controls.js", "readouts.js", "fields.js", "main.js", "sharing.js"),
)


def source(name: str) -> str:
    """A file of `web/`."""
    return importlib.resources.files("vibrocap.lab").joinpath("web", *name.split("/")).read_text(encoding="utf-8")


def script(names: tuple[str, ...]) -> str:
    """Scripts joined and shortened."""
    return shortened("\n".join(source(name) for name in names)).replace("</script", "<\\/script")


def page(data: Mapping[str, Any], title: str = "vibrocap lab") -> str:
    """The HTML of a page with the data of a `bundle`."""
    content = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return Template(source("lab.html")).substitute(
        title=escape(title),
        styles=re.sub(r"\n\s*", "\n", source("lab.css")),
        version=version("vibrocap"),
        data=content,
        worker=script(WORKER),
        scripts='"use strict";\n' + script(SCRIPTS),
    )
