# SPDX-License-Identifier: Apache-2.0
"""Runs a tool with a Python that has the tool's modules."""
import importlib.util
import os
import sys

DEBIAN_PYTHON = "/usr/bin/python3"


def use_a_python_with(*modules):
    """Starts the tool again with Debian's Python if this Python lacks a module. The first Python in PATH often lacks
    modules that Debian installs for its own. Exits with an error that names the tool if neither has them."""
    if any(importlib.util.find_spec(module) is None for module in modules):
        if os.path.realpath(sys.executable) == os.path.realpath(DEBIAN_PYTHON) or not os.path.exists(DEBIAN_PYTHON):
            sys.exit(f"{os.path.basename(sys.argv[0])}: {sys.executable} lacks one of {', '.join(modules)}, expected "
                     "python3-numpy and python3-openimageio to be installed")
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
