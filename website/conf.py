"""What Sphinx is told. It runs on the sources that `website.staging` lays out; see `website/__init__.py`."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # this package, where Sphinx is run by itself

import vibrocap
from website.docstrings import as_rst, members

project, author, copyright = "vibrocap", "The vibrocap developers", "the vibrocap developers"
version = release = installed("vibrocap")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx_design", "sphinx_copybutton"]
root_doc = "index"
nitpicky = True  # a reference that leads nowhere is a warning, and a warning fails the build

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_typehints = "none"  # docstrings tell what arguments are
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
toc_object_entries_show_parents = "hide"
python_maximum_signature_line_length = 70

html_theme = "pydata_sphinx_theme"
html_title = "vibrocap"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_favicon = "static/favicon.svg"
html_context = {"default_mode": "auto"}
html_show_sourcelink = False
html_theme_options = {
    "logo": {"text": "vibrocap"},
    "header_links_before_dropdown": 7,
    "show_prev_next": True,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["sphinx-version"],
    "show_toc_level": 2,
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": []}


def setup(app):
    """Have docstrings, which are plain text, made into reStructuredText, and what they leave to the code added."""

    def process(app, what, name, thing, options, lines):
        lines[:] = [*as_rst("\n".join(lines), vibrocap.__all__), *members(thing)]

    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True}
