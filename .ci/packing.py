"""setuptools as pyproject.toml names it, with the two things that a package index needs and a checkout does not.

The long description is README.md without what leads nowhere from elsewhere, pictures and links into the tree; the
source distribution has this file, by which it is built.
"""

import re

from setuptools.build_meta import *  # noqa: F403  the hooks of a build backend
from setuptools.command.egg_info import egg_info

# Code, which stays; tables of pictures; pictures with what is said below them; links into the tree, whose words stay.
PARTS = re.compile(r"(?P<kept>^```.*?^```|`[^`\n]*`)|(?:^\|[^\n]*\n)+?^\|[^\n]*!\[[^\n]*\n\n*|"
                   r"!\[[^]]*\]\([^)]*\)\n*(?:^\*[^*\n][^*]*\*\n*)?|"
                   r"\[(?P<words>[^]]*)\]\((?!https?://|#)[^)]*\)", re.MULTILINE | re.DOTALL)


def description(readme: str) -> str:
    """A long description from a README."""
    return PARTS.sub(lambda part: part["kept"] or part["words"] or "", readme)


class Packing(egg_info):
    """Metadata and the list of files, from which both kinds of distribution are made."""

    def run(self):
        metadata = self.distribution.metadata
        metadata.long_description = description(metadata.long_description)
        super().run()

    def find_sources(self):
        super().find_sources()
        self.filelist.append(".ci/packing.py")
