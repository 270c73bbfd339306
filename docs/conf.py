"""How Sphinx builds this site: `python -m sphinx -W -b html docs build/site`.

Nothing is fetched. Pages whose code is run as they are built (`{code-cell}`) are notebooks in
MyST; films, tables and the lists of the reference come from the package (`generate.py`).
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import answers  # noqa: E402 (beside this file)
import generate  # noqa: E402
from docstrings import prepare, restore  # noqa: E402

import powered_walker_env  # noqa: E402

project = "powered_walker_env"
author = "The powered_walker_env authors"
release = version = powered_walker_env.__version__
copyright = "The powered_walker_env authors"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["generated/*.md", "**.ipynb_checkpoints"]
templates_path = ["_templates"]
default_role = "py:obj"

html_theme = "furo"
html_title = "Powered walker"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_cache_path = str(HERE.parent / "build" / "notebooks")
nb_execution_raise_on_error = True
nb_execution_timeout = 240
nb_merge_streams = True

autosummary_generate = True
autodoc_typehints = "none"  # signatures and texts say them; types of numpy would fill lines
autodoc_member_order = "bysource"
autodoc_class_signature = "mixed"
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_custom_sections = [("Numbers", "params_style")]


def setup(app: Any) -> None:
    """Make what pages include, before they are read."""
    generate.everything(HERE / "generated", HERE / "reference")
    answers.answers(HERE / "generated", HERE)
    app.connect("autodoc-process-docstring", prepare, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", restore, priority=600)  # after it
