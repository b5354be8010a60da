# SPDX-License-Identifier: Apache-2.0
"""Runs a tool with a Python installation that contains the modules of the tool."""
import importlib.util
import os
import sys

DEBIAN_PYTHON = "/usr/bin/python3"


def use_a_python_with(*modules):
    """Starts the tool again with Debian's Python if this Python lacks a module. The first Python in PATH often lacks
    modules that Debian installs for its own Python. If neither Python has the modules, exits with an error that names
    the tool."""
    if any(importlib.util.find_spec(module) is None for module in modules):
        if os.path.realpath(sys.executable) == os.path.realpath(DEBIAN_PYTHON) or not os.path.exists(DEBIAN_PYTHON):
            sys.exit(f"{os.path.basename(sys.argv[0])}: {sys.executable} lacks one of {', '.join(modules)}, expected "
                     "python3-numpy and python3-openimageio to be installed")
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
