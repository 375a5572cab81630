# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The way of a signal: arrays that mark what is computed from them, and the files that have them.

A linear function of a signal is a signal (degree 1), a product of two of them a power or an energy
(degree 2), and so is a linear function of that. Anything else is marked no more.
"""

import collections
import contextlib
import sys

import numpy as np

LINEAR = {
    np.add, np.subtract, np.negative, np.positive, np.maximum, np.minimum, np.absolute,
}  # fmt: skip
# Which of several arrays is chosen, or where its values go, is no matter of their values.
ARRANGED = {
    np.where, np.stack, np.concatenate, np.take_along_axis, np.broadcast_to, np.broadcast_arrays,
    np.cumsum, np.sum, np.diff, np.nan_to_num, np.interp, np.clip, np.zeros_like, np.ravel,
}  # fmt: skip


class Traced(np.ndarray):
    """An array with its degree in the signals that it was computed from."""

    degree = 0

    def __array_finalize__(self, source):
        self.degree = getattr(source, "degree", 0)

    def __array_ufunc__(self, ufunc, method, *inputs, out=None, **options):
        plain = [_plain(each) for each in inputs]
        if out is not None:
            options["out"] = tuple(_plain(each) for each in out)
        found = getattr(ufunc, method)(*plain, **options)
        degrees = [_degree(each) for each in inputs]
        if ufunc in LINEAR:
            return traced(found, max(degrees))
        if ufunc is np.multiply:
            return traced(found, sum(degrees))
        if ufunc is np.divide and not degrees[1]:
            return traced(found, degrees[0])
        return found

    def __array_function__(self, function, types, arguments, options):
        found = function(*_plain(arguments), **{k: _plain(v) for k, v in options.items()})
        return traced(found, degree_of(arguments)) if function in ARRANGED else found


def traced(value, degree=1):
    """Return a value marked."""
    if isinstance(value, (list, tuple)):
        return type(value)(traced(each, degree) for each in value)
    if not 1 <= degree <= 2:
        return value
    found = np.asarray(value).view(Traced)
    found.degree = degree
    return found


def _plain(value):
    if isinstance(value, Traced):
        return value.view(np.ndarray)
    if type(value) in (list, tuple):
        return type(value)(_plain(each) for each in value)
    return value


def _degree(value):
    return value.degree if isinstance(value, Traced) else 0


def degree_of(value, depth=3):
    """Return the degree of a value: of an array, or the largest in a collection or a record."""
    if isinstance(value, Traced) or not depth:
        return _degree(value)
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, (list, tuple)):
        return max((degree_of(each, depth - 1) for each in value), default=0)
    return _degree(getattr(value, "wave", None))  # of a packet


@contextlib.contextmanager
def files(degree):
    """Yield a mapping from each file to how many of its functions were given a value of this
    degree (``into``), and returned one (``out``).
    """
    found = collections.defaultdict(collections.Counter)

    def watch(frame, event, value):
        code = frame.f_code
        if event not in ("call", "return") or "/pmwvc_" not in code.co_filename:
            return
        if event == "call":
            names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
            seen = max((degree_of(frame.f_locals.get(n)) for n in names if n != "self"), default=0)
        else:
            seen = degree_of(value)
        if seen == degree:
            file = code.co_filename[code.co_filename.rindex("/pmwvc_") + 1 :]
            found[file]["into" if event == "call" else "out"] += 1

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        yield found
    finally:
        sys.setprofile(before)
