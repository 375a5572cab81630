# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A fake of a vendor's library, made by the C compiler, and the variables that tests set."""

import ctypes
import functools
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest

COMPILER = shutil.which("cc") or shutil.which("gcc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the fake library")


@functools.cache
def bytes_of(source, *options):
    """Compile a file of this folder; return the library."""
    flags = ["-shared", "-fPIC", "-pthread", *options]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "library.so"
        subprocess.run(
            [COMPILER, *flags, "-o", path, Path(__file__).with_name(source)], check=True
        )
        return path.read_bytes()


def compiled(folder, source, name, *options):
    """Compile a file of this folder into a library of a name; return its path."""
    path = folder / name
    path.write_bytes(bytes_of(source, *options))
    return path


class FakeLibrary:
    """The variables of a fake library, and the device that a test has opened at it last."""

    def __init__(self, path, made):
        self.path, self.made = str(path), made
        self._library, self._device = ctypes.CDLL(str(path)), None

    def vector(self, name, size=3):
        return (ctypes.c_double * size).in_dll(self._library, f"fake_{name}")

    def number(self, name):
        return ctypes.c_double.in_dll(self._library, f"fake_{name}")

    def text(self, name, text):
        (ctypes.c_char * 32).in_dll(self._library, f"fake_{name}").value = text.encode()

    def __getitem__(self, name):
        return ctypes.c_int.in_dll(self._library, f"fake_{name}").value

    def __setitem__(self, name, value):
        ctypes.c_int.in_dll(self._library, f"fake_{name}").value = value

    def opened(self, dof=1, **params):
        self.close()
        self._device = self.made(dof, **({"library": self.path} | params))
        self._device.open()
        return self._device

    def close(self):
        if self._device is not None:
            self._device.close()
