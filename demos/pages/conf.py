"""Settings of Sphinx, which makes a site of the pages, the demos and the names of sheetfx; see `make` beside it.

`make` copies `demos` and works on the copy: pages of the reference are written into it, one for each room, and the home
page gets the tree of pages that navigation shows.
"""

import inspect
import re
import shutil
import sys
from operator import attrgetter
from pathlib import Path
from textwrap import indent

import jupytext
from docutils import nodes
from latex2mathml.converter import convert
from myst_parser.parsers.sphinx_ import MystParser

import sheetfx as fx

sys.path.insert(0, str(Path(__file__).parent))
import outputs

project, root_doc, html_title = "sheetfx", "pages/index", "sheetfx"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
FOLDERS = ["advice", "failure_map", "peers", "studies"]  # of scripts that are no demos
exclude_patterns = [*(f"{folder}/*" for folder in FOLDERS), "failure_map/traps/*", "pages/conf.py",
                    "pages/outputs.py", "outputs/**",
                    "dome.py", "double_plate.py"]  # of which pages have the names
myst_enable_extensions, myst_heading_anchors = ["dollarmath"], 2
autodoc_typehints, autodoc_member_order, napoleon_use_ivar = "description", "bysource", True
autodoc_typehints_description_target = "documented"
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
default_role = "literal"
html_theme, html_math_renderer, html_copy_source = "furo", "mathml", False
html_theme_options = {"navigation_with_keys": True}
html_css_files = ["site.css"]
WEAK_FORMS = [f"forms.{name}" for name in ("bar", "beam", "shell", "section", "contact", "interface", "load")]
ROOMS = {"forms": "Weak forms", "meshes": "Meshes: geometry", "mesh": "Meshes: reading, groups, imperfect shapes",
         "model": "What is modelled", "discrete": "Contributions of one's own", "continuation": "Controls and transfer",
         "events": "Events", "critical": "Critical points, branches, buckling", "path": "Paths, records, cases",
         "ladder": "Advice, refinement", "show": "Pictures"}
NAVIGATION = {
    "Start": ["install", "first_scene", "your_model", "coming_from", "scenes", "pictures", "results", "gallery"],
    "Model": ["shells", "joints", "contact", "plasticity", "heat_and_prestress", "own_mesh", "forms"],
    "Weak forms of one's own": ["own_weak_form", "own_law", "own_load", "plain_forms"],
    "Stability": ["stability", "critical_points", "method", "curves", "imperfections"],
    "Accuracy and speed": ["error_bars", "advice", "speed", "limits"],
    "Studies": ["panel", "../dome", "../dome_contact", "../double_plate", "../plastic_cylinder", "../tested",
                "../failure_map", "../assumed_strains"],
    "Reference": [f"reference/{room}" for room in ROOMS],
}


class Percent(MystParser):
    """Demos in percent format as Markdown."""

    supported = ("percent",)

    def parse(self, inputstring, document):
        notebook = jupytext.reads(inputstring, fmt="py:percent")
        text = jupytext.writes(notebook, fmt="md").split("---\n", 2)[-1]
        super().parse(inside(text) + outputs.shown(document.settings.env.docname), document)


def inside(text: str) -> str:
    """Links that leave the site as plain words."""
    return re.sub(rf"\[([^\]]*)\]\((?:\.\./)*(?:sheetfx|tests|docker|{'|'.join(FOLDERS)})/[^)]*\)", r"\1", text)


def room_of(name: str) -> str:
    """The room whose page has a public name."""
    room = name if name in fx._MODULES else fx._HOMES.get(name, "forms").split(".")[0]
    return room if room in ROOMS else "path"


def entry(name: str) -> str:
    """A public name with its docstring, and with what is in it."""
    if name == "continuation":  # a room too, of which a user calls the function
        return "```{eval-rst}\n.. autofunction:: sheetfx.plain.continuation\n```\n"
    thing = attrgetter(name)(fx)
    kind = "module" if inspect.ismodule(thing) else "class" if inspect.isclass(thing) else "function"
    members = "" if kind == "function" else "   :members:\n"
    return f"```{{eval-rst}}\n.. auto{kind}:: sheetfx.{name}\n{members}```\n"


def write_reference(app, _):
    """A page for each room."""
    folder = Path(app.srcdir) / "pages" / "reference"
    folder.mkdir()
    for room, title in ROOMS.items():
        names = [name for name in [*dir(fx), *WEAK_FORMS] if room_of(name) == room and name != "forms"]
        (folder / f"{room}.md").write_text(f"# {title}\n\n" + "\n".join(map(entry, names)))


def as_restructured_text(app, what, name, thing, options, lines):
    """Examples as blocks of code, bars as characters, what is said of a name as its description, not as its type."""
    text = "\n".join(line.replace("|", "\\|") for line in lines)
    text = re.sub(r"^([\w*]+(?:, [\w*]+)*) : (.+)$", r"\1\n    \2", text, flags=re.MULTILINE)
    parts = re.split(r"```(?:python)?\n", text + "\n")  # by turns prose and code
    parts[1::2] = [".. code-block:: python\n\n" + indent(code, "   ") for code in parts[1::2]]
    lines[:] = "\n".join(parts).splitlines()


def titled(page: str) -> str:
    """An entry of the tree, with a short title."""
    name = page.rpartition("/")[2]
    return f"{ROOMS[name] if page.startswith('reference/') else name.replace('_', ' ').capitalize()} <{page}>"


def tree(pages: list[str], caption: str = "") -> str:
    """A tree of pages, which navigation shows."""
    return "\n".join(["", "```{toctree}", ":hidden:", f":caption: {caption}" if caption else "", "", *pages, "```", ""])


def add_navigation(app, document, source):
    """Put the tree of pages below the home page, and the scripts below the gallery."""
    source[0] = inside(source[0])
    if document == root_doc:
        source[0] += "".join(tree(list(map(titled, pages)), caption) for caption, pages in NAVIGATION.items())
    if document == "pages/gallery":
        scripts = sorted(path for path in Path(app.srcdir).glob("*.py") if path.name not in exclude_patterns)
        source[0] += tree([f"../{path.stem}" for path in scripts])


def copy_style(app, failure):
    """The style beside what Sphinx has copied itself, which refuses files of a source below the site."""
    if not failure:
        shutil.copy(Path(__file__).with_name("site.css"), Path(app.outdir) / "_static")


def formula(writer, node, display: str = "block"):
    """MathML, which browsers draw by themselves."""
    writer.body.append(convert(node.astext(), display=display))
    raise nodes.SkipNode


def setup(app):
    app.add_source_suffix(".py", "percent")
    app.add_source_parser(Percent)
    app.add_html_math_renderer("mathml", (lambda writer, node: formula(writer, node, "inline"), None), (formula, None))
    app.connect("config-inited", write_reference)
    app.connect("build-finished", copy_style)
    app.connect("source-read", add_navigation)
    app.connect("autodoc-process-docstring", as_restructured_text, priority=100)
