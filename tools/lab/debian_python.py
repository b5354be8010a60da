# SPDX-License-Identifier: Apache-2.0
"""Runs a tool by a Python that has what it imports."""
import importlib.util
import os
import sys

DEBIAN_PYTHON = "/usr/bin/python3"


def use_a_python_with(*modules):
    """The first Python in PATH often lacks what Debian has installed for its own: starts again with that one. Exits
    naming the running tool where neither has them."""
    if any(importlib.util.find_spec(module) is None for module in modules):
        if os.path.realpath(sys.executable) == os.path.realpath(DEBIAN_PYTHON) or not os.path.exists(DEBIAN_PYTHON):
            sys.exit(f"{os.path.basename(sys.argv[0])}: {sys.executable} lacks one of {', '.join(modules)}, expected "
                     "python3-numpy and python3-openimageio to be installed")
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
