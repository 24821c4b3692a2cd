"""The page on school laptops: its commands are commands, its links lead somewhere."""

import re
import shlex

import pytest

from conftest import ROOT
from stereo_lab.cli import _parser

PAGE = (ROOT / "docs" / "school_laptops.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"(?:python3|py) lab\.py ((?!--)[a-z][^`\n]*)", PAGE)


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_of_the_page_is_one(words):
    assert _parser().parse_args(shlex.split(words)).run


def test_there_are_commands_and_links_lead_somewhere():
    assert len(COMMANDS) >= 2 and "--offline" in PAGE
    for link in re.findall(r"\]\((?!http)([^)#]+)\)", PAGE + (ROOT / "README.md").read_text(encoding="utf-8")):
        assert (ROOT / "docs" / link).exists() or (ROOT / link).exists(), link
