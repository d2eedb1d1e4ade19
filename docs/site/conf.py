# SPDX-License-Identifier: Apache-2.0
"""How Sphinx makes the site of the project's documents and sources; build.py calls it."""
from __future__ import annotations

import functools
import os
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

from breathe.renderer.sphinxrenderer import SphinxRenderer
from docutils import nodes
from sphinx import addnodes
from sphinx.parsers import RSTParser
from sphinx.search.en import SearchEnglish

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from build import PROJECT, headers  # noqa: E402

project = "Thenar"
version = release = re.search(r"project\(thenar VERSION ([\d.]+)", (PROJECT / "CMakeLists.txt").read_text()).group(1)
html_title = f"Thenar {version}"
extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
root_doc = "docs/index"
source_suffix = {".md": "markdown", ".rst": "restructuredtext", ".h": "source", ".cpp": "source", ".py": "source"}
myst_heading_anchors = 6
highlight_language = "none"  # of a block that names no language

breathe_projects = {"thenar": os.environ["THENAR_DOXYGEN"]}
breathe_default_project = "thenar"
breathe_default_members = ("members", "undoc-members")
autodoc_member_order = "bysource"
TYPES = ("Array", "Law", "npt.ArrayLike", "_core.Period", "_core.Scene")
autodoc_type_aliases = {name: name.split(".")[-1] for name in TYPES}
default_role = "literal"  # In docstrings, as in Markdown.

html_theme = "furo"
html_static_path = ["style.css", "theme.js"]
html_css_files = ["style.css"]
html_js_files = ["theme.js"]
html_extra_path = ["start"]
html_copy_source = False
html_use_index = html_domain_indices = False  # The search finds declarations.
html_show_search_summary = False  # It would be fetched, which browsers refuse where a page is a file.
html_show_copyright = False
html_search_language = "questions"
html_search_scorer = str(PROJECT / "docs/site/scorer.js")

# Figures, lists and histories have every word: they are found by their titles alone.
NOT_SEARCHED = {"docs/measured", "docs/MODULES", "CHANGELOG"}

# What comes below a page, in groups. It stands here, not in the page, where it would be read as it is on GitHub.
GUIDES = ("run window scenes objects hands tasks environment controller python embed realtime reflex stiffness sweeps "
          "problems measure truth refusals paper").split()
REFERENCE = "scene results fields measures recordings window muscles problem_files".split()
BELOW = {
    "docs/index": {
        "Guides": [f"guide/{name}" for name in GUIDES],
        "Reference": [f"reference/{name}" for name in REFERENCE] + ["site/python", "C++ modules <MODULES>"],
        "Background": ["ARCHITECTURE", "DEPARTURES", "NOTATION", "decisions/README", "measured"],
        "Project": ["/CONTRIBUTING", "/SECURITY", "/CHANGELOG"],
    },
    "docs/decisions/README": {"Decisions": sorted(path.stem for path in (PROJECT / "docs/decisions").glob("0*.md"))},
}
LANGUAGES = {".cpp": "cpp", ".py": "python"}
INSTALLED = {str(path.relative_to(PROJECT)) for path in headers()}


class Questions(SearchEnglish):
    """English as it is asked in. Pages that are found have all words of a question, but for these."""
    lang = "questions"
    language_name = "Questions"
    stopwords = SearchEnglish.stopwords | set(
        "about all am any can could do does from get give go has have how i me much must my need one our over own set "
        "should so some tell than them use using want we what when where which who why would you your".split())


class Source(RSTParser):
    """The page of a source: the declarations of an installed header, as doxygen reads them, or the text as it is."""
    supported = ("source",)

    def parse(self, inputstring: str, document: nodes.document) -> None:
        name = os.path.relpath(document["source"], self.env.srcdir)
        content = f".. doxygenfile:: {name}"
        if name not in INSTALLED:
            content = f".. literalinclude:: /{name}\n   :language: {LANGUAGES[Path(name).suffix]}"
        super().parse(f":orphan:\n\n{name}\n{'=' * len(name)}\n\n{content}\n", document)


def show_namespace(renderer, node):
    """What a header declares in a namespace, without declaring the namespace in each header again."""
    namespace = renderer.compound_parser.parse(node.refid)
    # Doxygen gathers here what stands above the namespace in all headers.
    namespace.compounddef.briefdescription = namespace.compounddef.detaileddescription = None
    return renderer.render(namespace, renderer.context.create_child_context(namespace))


def shorten_signature(app, what, name, object, options, signature: str | None, returned: str | None):
    """The signature of a compiled function, with the names of the package in place of those behind it."""
    def short(text: str | None) -> str | None:
        text = text and re.sub(r"thenar::python::(\w+)Handle", r"\1", text).replace("thenar._core.", "")
        return text and re.sub(r"^\(self: \w+(, )?", "(", text)
    return short(signature), short(returned)


def leave_names_of_others(app, doctree: nodes.document) -> None:
    """Makes text of the names in declarations that no header of ours declares: Sphinx takes long to look for each."""
    for node in list(doctree.findall(addnodes.pending_xref)):
        if node.get("refdomain") == "cpp" and node["reftarget"].split("::")[-1] not in declared_names():
            node.replace_self(node.children)


def add_what_is_below(app, docname: str, source: list[str]) -> None:
    for caption, pages in BELOW.get(docname, {}).items():
        source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n" + "\n".join(pages) + "\n```\n"


@functools.cache
def declared_names() -> frozenset[str]:
    index = ElementTree.parse(os.path.join(breathe_projects["thenar"], "index.xml"))
    return frozenset(name.text.split("::")[-1] for name in index.iter("name"))


def leave_out_of_search(app, doctree: nodes.document) -> None:
    if app.env.docname in NOT_SEARCHED:
        app.env.metadata[app.env.docname]["nosearch"] = True


def show_without_link(app, env, node, content):
    """A link to a folder of the project, or to a header that is not installed: the site has no page of it."""
    target = PROJECT / os.path.normpath(os.path.join(os.path.dirname(node["refdoc"]), node["reftarget"]))
    return content if target.is_dir() or target.suffix == ".h" and target.is_file() else None


def setup(app) -> dict:
    SphinxRenderer.visit_namespace = show_namespace
    app.add_source_parser(Source)
    app.add_search_language(Questions)
    app.connect("autodoc-process-signature", shorten_signature)
    app.connect("source-read", add_what_is_below)
    app.connect("doctree-read", leave_names_of_others)
    app.connect("doctree-read", leave_out_of_search)
    app.connect("missing-reference", show_without_link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
