"""Sphinx settings of the documentation; docs/site/build.py uses them."""

from __future__ import annotations

import re
from functools import lru_cache

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform

project = "ecyl_ros"
author = "The ecyl_ros founders"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
if not tags.has("no_sources"):  # noqa: F821 (Sphinx gives it)
    extensions.append("sphinx.ext.viewcode")
root_doc = "index"
include_patterns = [
    "index.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "README.md",
    "api/**",
    "bags/README.md",
    "docs/*.md",
    "docs/effects/*.md",
    "docs/field/*.md",
    "docs/notebooks/*.ipynb",
    "rclpy_cyclone/README.md",
]
myst_heading_anchors = 4
nb_execution_mode = "off"  # docs/notebooks/execute.py runs them
default_role = "code"  # `name` in a docstring is code, as in Markdown
napoleon_numpy_docstring = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_use_type_comments = False  # nothing here has its types in comments
# A name that a package hands on is described where it is defined, once.
autodoc_default_options = {"ignore-module-all": True}
html_theme = "alabaster"
# Beside a page of the reference stand its own contents: all modules would be a list of hundreds.
html_sidebars = {"api/**": ["about.html", "searchfield.html", "localtoc.html", "relations.html"]}
html_theme_options = {"page_width": "1100px", "sidebar_width": "240px"}
# A word like `type` in a signature is the built-in, whatever attributes have that name.
suppress_warnings = ["ref.python"]
html_title = "ecyl_ros"


def _markdown_bars(app, what, name, subject, options, lines):  # type: ignore[no-untyped-def]
    """What bars mean in a docstring: rows of a table, or |x|, an absolute value."""
    rows: list[str] = []
    out: list[str] = []
    for line in [*lines, ""]:
        if line.startswith("|") and line.endswith("|") and line.count("|") > 2:
            rows.append(line)
            continue
        if rows:
            cells = [[cell.strip() for cell in row.strip(" |").split("|")] for row in rows]
            out += [".. list-table::", "   :header-rows: 1", ""]
            for row in [cells[0], *cells[2:]]:
                out += [f"   {'  -' if index else '* -'} {cell}" for index, cell in enumerate(row)]
            rows = []
        out.append(line.replace("|", r"\|"))
    lines[:] = out


def _fields_apart(app, what, name, subject, options, lines):  # type: ignore[no-untyped-def]
    """`a, b: words` describes two parameters or attributes alike; Sphinx takes `a,` for a type."""
    out: list[str] = []
    index = 0
    while index < len(lines):
        found = re.match(r":(ivar|param) (\w+(?:, \w+)+):(.*)", lines[index])
        last = index + 1
        while last < len(lines) and lines[last].startswith(" "):
            last += 1
        if found is None:
            out += lines[index:last]
        else:
            for one in found[2].split(", "):
                out += [f":{found[1]} {one}:{found[3]}", *lines[index + 1 : last]]
        index = last
    lines[:] = out


class Foreign(SphinxPostTransform):
    """Types of Python and of other packages are no references: Sphinx would look through all that
    there is for each of them, a fifth of its time, and find nothing."""

    default_priority = 5  # before references are resolved

    def run(self, **kwargs: object) -> None:
        """See Sphinx."""
        own = self._own(self.env)
        for node in list(self.document.findall(pending_xref)):
            if node["refdomain"] == "py" and node["reftarget"].rsplit(".", 1)[-1] not in own:
                node.replace_self(nodes.inline("", "", *node.children))

    @staticmethod
    @lru_cache(maxsize=1)
    def _own(env: BuildEnvironment) -> frozenset[str]:
        """Last names of all that is described; every document asks for the same."""
        return frozenset(name.rsplit(".", 1)[-1] for name in env.domains.python_domain.objects)


def setup(app):  # type: ignore[no-untyped-def]
    """Sphinx calls this."""
    app.add_post_transform(Foreign)
    # After napoleon, which makes the fields and would take the backslashes for its own.
    app.connect("autodoc-process-docstring", _fields_apart, priority=900)
    app.connect("autodoc-process-docstring", _markdown_bars, priority=900)
