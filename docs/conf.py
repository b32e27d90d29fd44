"""How the documentation is built: `make docs`.

Sphinx, because the reference comes out of the docstrings, the pages are the Markdown files that a reader of
the repository sees too (MyST), and a dead link or a page that no list names is a warning, which `make docs`
makes an error.
"""

import re
from pathlib import Path

from sphinx.util import logging

import treelet

project = "treelet"
author = "The treelet authors"
copyright = author
release = version = treelet.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
html_theme = "furo"
html_title = f"treelet {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]

myst_heading_anchors = 3  # so that links to sections are checked
myst_links_external_new_tab = False
napoleon_use_rtype = False  # types are in the signatures
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}  # its definition fills three lines
python_use_unqualified_type_names = True
default_role = "py:obj"  # `build` in a docstring is a name, and a link where it is documented
copybutton_prompt_text = "$ "

DOCS = Path(__file__).parent
LINK = re.compile(r"(?<!!)\[(?P<text>[^\]]+)\]\((?P<target>\.\./[^)#\s]+)[^)\s]*\)")


def keep_links_inside(app, document, source):
    """Show links to sources and measurements as text: those files lie in the repository, not on this site."""
    folder = (DOCS / document).parent

    def as_text(link):
        target = (folder / link["target"]).resolve()
        if target.is_relative_to(DOCS):
            return link[0]
        if not target.exists():
            logging.getLogger(__name__).warning("%s: no file %s", document, link["target"])
        return link["text"]

    source[0] = LINK.sub(as_text, source[0])


def tidy_docstring(app, what, name, obj, options, lines):
    """Docstrings are text with names in backticks: keep what else they hold from being read as markup."""
    if lines and lines[0].startswith("Alias for field number"):  # Python says that of a field without one
        lines.clear()
    if lines and what in ("attribute", "property"):  # napoleon takes "this: that" for a type and a text
        lines[0] = re.sub(r'"(\S+)"', r"``\1``", lines[0].replace(": ", " – "))
    lines[:] = [line.replace("*", r"\*") for line in lines]


def setup(app):
    """Called by Sphinx."""
    app.connect("source-read", keep_links_inside)
    app.connect("autodoc-process-docstring", tidy_docstring, priority=400)  # before napoleon
