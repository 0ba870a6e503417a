"""Make pages of the reference, and pictures, while the documentation is built: none is kept in the repository."""

from __future__ import annotations

import sys
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

sys.path.insert(0, str(Path(__file__).resolve().parent))

import pictures
import reference


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is generated from commands, settings, measures, schemas and motion."""
    for name, page in reference.pages().items():
        files.append(File.generated(config, name, content=page))
    for name, picture in pictures.all_pictures().items():
        files.append(File.generated(config, name, content=picture))
    return files
