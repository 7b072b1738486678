# What Sphinx lacks for Spall's pages: tables of `spall keys`, formulas without scripts, links to
# folders.
# SPDX-License-Identifier: BSD-3-Clause
import os
import re
import subprocess

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util.docutils import SphinxDirective
from sphinx.util.nodes import make_refnode

FIELDS = "Fields of bodies in snapshots and trajectories (H5MD)"


def read_keys(text):
    """Rows (depth, name, kind, default, meaning) of what `spall keys` prints."""
    for line in text.splitlines():
        name, kind, rest = line[:24].rstrip(), line[25:39].rstrip(), line[40:]
        default, meaning = rest[:11], rest[12:]
        if rest[11:12].strip():  # longer than its column
            default, _, meaning = rest.partition(" ")
        depth = (len(name) - len(name.lstrip())) // 2
        if not re.fullmatch(r" *\w+", name) or line[24:25].strip() or line[39:40].strip():
            raise ValueError(f"this is no line of `spall keys`: {line}")
        yield depth, name.strip(), kind, default.strip(), meaning.strip()


class Keys(SphinxDirective):
    """A section for each table of a case, with a row for each key; or the fields of bodies."""

    def run(self):
        text = subprocess.run(["spall", "keys"], check=True, capture_output=True, text=True).stdout
        cases, _, fields = text.partition("\n" + FIELDS + "\n")
        top = self.section("The case itself", "keys-case")
        sections, path, rows = [top], [], {id(top): []}
        for depth, name, kind, default, meaning in read_keys(cases.rstrip()):
            del path[depth:]
            path.append(name)
            if depth == 0 and kind.startswith("table"):
                title = f"[[{name}]]" if kind == "tables" else f"[{name}]"
                sections.append(self.section(title, f"keys-{name}"))
                sections[-1] += nodes.paragraph(text=meaning.removeprefix(title + ": "))
                rows[id(sections[-1])] = []
                continue
            to = sections[-1] if depth else top
            key = ".".join(path[1:] if depth else path)
            rows[id(to)].append((key, kind, default, meaning))
        for section in sections:
            section += table(("key", "unit or type", "default", "meaning"), rows[id(section)])
        last = self.section(FIELDS, "fields")
        last += table(("field", "unit", "in files", "meaning"),
                      [(l[:22].strip(), l[23:37].strip(), l[38:49].strip(), l[50:].strip())
                       for l in fields.splitlines()])
        return [*sections, last]

    @staticmethod
    def section(title, name):
        section = nodes.section(ids=[name], names=[name])
        section += nodes.title(text=title)
        return section


def table(head, rows):
    """A docutils table; the first column is code."""
    group = nodes.tgroup(cols=len(head))
    group += [nodes.colspec(colwidth=width) for width in (24, 14, 12, 50)]
    for kind, lines in ((nodes.thead(), [head]), (nodes.tbody(), rows)):
        for line in lines:
            row = nodes.row()
            for column, cell in enumerate(line):
                code = column == 0 and isinstance(kind, nodes.tbody)
                text = nodes.literal(text=cell) if code else nodes.Text(cell)
                row += nodes.entry("", nodes.paragraph("", "", text))
            kind += row
        group += kind
    return nodes.table("", group, classes=["keys"])


def inline_math(writer, node):
    writer.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def display_math(writer, node):
    writer.body.append(f'<div class="math">{tex2mathml(node.astext(), inline=False)}</div>')
    raise nodes.SkipNode


def link_to_folder(app, env, node, contnode):
    """A folder's page is its README, as on every forge; one without is named, but no link."""
    if node.get("refdomain"):
        return None
    target = os.path.normpath(os.path.join(os.path.dirname(node["refdoc"]), node["reftarget"]))
    page = f"{target}/README"
    if page in env.found_docs:
        return make_refnode(app.builder, node["refdoc"], page, None, contnode)
    return contnode if os.path.isdir(os.path.join(app.srcdir, target)) else None


def setup(app):
    app.add_directive("spall-keys", Keys)
    app.add_html_math_renderer("mathml", (inline_math, None), (display_math, None))
    app.connect("missing-reference", link_to_folder)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
