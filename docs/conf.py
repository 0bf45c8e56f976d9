"""The site's settings. `tools/make_site.py` runs sphinx with them, over a copy of these pages in out/."""

import sys
from pathlib import Path

from dampyr import __version__

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))  # sphinx_docstrings

project = "dampyr"
author = "The dampyr authors"
copyright = "The dampyr authors, MIT licence"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_docstrings",
    "sphinx_copybutton",
    "sphinx-mathjax-offline",  # MathJax itself comes with the site, which loads nothing from a network
]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4  # the same anchors as in a repository browser
myst_dmath_double_inline = True

default_role = "py:obj"  # `name` in a docstring: a link where such a name is documented, code elsewhere
add_module_names = False
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
autosummary_generate = False
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("Array", "Bools", "Ints", "Complex")}
napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = "dampyr"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_show_search_summary = False  # it would be fetched, which a browser refuses for files
pygments_style = "friendly"
pygments_dark_style = "monokai"
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True
