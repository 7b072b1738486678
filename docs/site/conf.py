# The documentation site: Sphinx reads the markdown pages of the tree where they lie.
# SPDX-License-Identifier: BSD-3-Clause
import os
import sys
from pathlib import Path

here = Path(__file__).resolve().parent
root = here.parents[1]
build = Path(os.environ["SPALL_BUILD"])  # set by docs/build.sh
sys.path[:0] = [str(here), str(build / "python")]

project = "Spall"
copyright = "Spall's authors"
root_doc = "docs/index"
include_patterns = ["docs/*.md", "docs/guides/*.md", "docs/physics/*.md", "README.md",
                    "CONTRIBUTING.md",
                    "CHANGELOG.md", "src/README.md", "packaging/README.md",
                    "src/output/*/README.md", "bench/README.md", "bench/results/*.md",
                    "cases/*/*.md"]
exclude_patterns = ["build", "out", ".git"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "breathe", "sphinxcontrib.programoutput",
              "matplotlib.sphinxext.plot_directive", "spall_site"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # of tables that scripts write, parts of other pages
highlight_language = "text"
html_math_renderer = "mathml"  # no script, no network

html_theme = "furo"
html_title = "Spall"
html_copy_source = False
html_show_copyright = False
html_extra_path = ["index.html"]  # the site's root leads to docs/index.html

autodoc_member_order = "bysource"
autodoc_typehints = "none"

breathe_projects = {"spall": os.environ["SPALL_DOXYGEN"]}
breathe_default_project = "spall"

plot_working_directory = str(root)
plot_basedir = str(root / "docs" / "figures")
plot_formats = ["svg"]
plot_html_show_formats = False
plot_html_show_source_link = False

linkcheck_ignore = [r"https://www\.sciencedirect\.com/.*"]  # refuses programs
