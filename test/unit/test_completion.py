# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Shell completion, asked as a shell asks."""

import subprocess

import pytest
from support.command_line import ROOT

ASK = """
export COMP_LINE="$1" COMP_POINT=${#1} COMP_TYPE=9 COMP_KEY=9
export _ARGCOMPLETE=1 _ARGCOMPLETE_IFS=' ' _ARGCOMPLETE_COMP_WORDBREAKS=' ='
"$2" 8>&1 9>/dev/null
"""


def completed(line):
    """Return the words a shell is offered at the end of a line."""
    command = ["bash", "-c", ASK, "ask", line, str(ROOT / "pmwvc")]
    result = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    return result.stdout.split()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("./pmwvc sim", {"simulate"}),
        ("./pmwvc simulate carry_1", {"carry_16ms"}),
        ("./pmwvc simulate wall --set server.contact_s", {"server.contact_stiffness="}),
        ("./pmwvc simulate wall --set link.del", {"link.delay_s="}),
        ("./pmwvc simulate wall --set link.preset=5", {"5g_sa_campus", "5g_nsa_public"}),
        ("./pmwvc report pmwvc_br", {"pmwvc_bringup/"}),
        ("./pmwvc node re", {"recorder"}),
    ],
)
def test_a_begun_word_is_completed(line, words):
    assert set(completed(line)) == words


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_code_for_a_shell_names_the_program(shell):
    result = subprocess.run(
        [ROOT / "pmwvc", "completion", shell], capture_output=True, text=True, check=True
    )
    assert "pmwvc" in result.stdout
    if shell == "bash":
        subprocess.run(["bash", "-n"], input=result.stdout, text=True, check=True)
