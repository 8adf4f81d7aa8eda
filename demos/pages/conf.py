"""Settings of Sphinx, which makes a site of the pages, the demos and the names of sheetfx; see `make` beside it."""

import inspect
from operator import attrgetter

import jupytext
from myst_parser.parsers.sphinx_ import MystParser

import sheetfx as fx

project, root_doc = "sheetfx", "pages/index"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["peers", "pages/conf.py", "dome.py"]  # the page dome.md has the name of its script
myst_enable_extensions, myst_heading_anchors = ["dollarmath"], 2
autodoc_typehints, autodoc_member_order, napoleon_use_ivar = "none", "bysource", True
suppress_warnings = ["myst.xref_missing", "myst.header", "toc.not_included", "misc.highlighting_failure"]
html_theme_options = {"nosidebar": True, "page_width": "60em"}
REFERENCE = "pages/reference"
WEAK_FORMS = [f"forms.{name}" for name in ("bar", "beam", "shell", "section", "contact", "interface", "load")]


class Percent(MystParser):
    """Demos in percent format as Markdown."""

    supported = ("percent",)

    def parse(self, inputstring, document):
        notebook = jupytext.reads(inputstring, fmt="py:percent")
        super().parse(jupytext.writes(notebook, fmt="md").split("---\n", 2)[-1], document)


def entry(name: str) -> str:
    """A public name with its docstring, and with what is in it."""
    if name == "continuation":  # a room too, of which a user calls the function
        return "```{eval-rst}\n.. autofunction:: sheetfx.plain.continuation\n```\n"
    thing = attrgetter(name)(fx)
    kind = "module" if inspect.ismodule(thing) else "class" if inspect.isclass(thing) else "function"
    members = "" if kind == "function" else "   :members:\n"
    return f"```{{eval-rst}}\n.. auto{kind}:: sheetfx.{name}\n{members}```\n"


def add_names(app, document, source):
    """Put all public names under the head of the page of reference."""
    if document == REFERENCE:
        source[0] += "\n" + "\n".join(map(entry, [*dir(fx), *WEAK_FORMS]))


def setup(app):
    app.add_source_suffix(".py", "percent")
    app.add_source_parser(Percent)
    app.connect("source-read", add_names)
