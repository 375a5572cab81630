# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Laws compiled by Numba, for work in bulk; nothing live ever loads this.

A compiled law is made from the source of the law itself. The functions it calls are compiled with
it: each gets a copy of its globals in which laws are their compiled forms. Families are resolved
by the type of the first argument, and what builds tuples has one line per element. NamedTuples
have ``_replace``.
"""

import hashlib
import inspect
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import types
from numba.core.imputils import impl_ret_borrowed, lower_builtin, lower_constant
from numba.core.registry import CPUDispatcher
from numba.core.typing import templates
from numba.extending import models, overload, register_model

from pmwvc_core.law import vectors
from pmwvc_core.law.family import Family
from pmwvc_core.unrolled import LAWS, is_law, relinked, unrolled

# As quick as 3 here, compiled in two thirds of the time.
numba.config.OPT = type(numba.config.OPT)(1)
# A loop over laws is called instead: once for all users of a kind, and quicker to compile.
INLINED = ("pmwvc_core.law", "pmwvc_core.plant")

# Of what only compiled laws call: no form that takes Python's objects.
BARE = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class LawType(types.Dispatcher):
    """The type of a compiled law, which is all that is handed on where a law is an argument: the
    address of one would keep what is compiled from being kept on disk.
    """


register_model(LawType)(models.OpaqueModel)


@lower_constant(LawType)
def _no_address(context, builder, kind, law):
    return context.get_dummy_value()


class CompiledLaw(CPUDispatcher):
    """A compiled law."""

    @property
    def _numba_type_(self):
        return LawType(self)


@cache
def compiled(law: Callable[..., Any], *, kept: bool = False) -> Any:
    """Return the compiled form of a law: takes and returns the same, NamedTuples included.

    ``kept`` keeps it on disk for later processes, in a folder by the hash of all laws.
    """
    if kept:
        numba.config.CACHE_DIR = str(kept_in())
    # Inlined, a state stays in registers: half the time, compiled as quickly.
    return _made(law, cache=kept, forceinline=not kept)


@cache
def _inside(law: Callable[..., Any]) -> Any:
    """Return the compiled form of a law that only compiled laws call: what takes its arguments
    from Python and gives results back would be most of it.
    """
    return _made(law, forceinline=law.__module__.startswith(INLINED), **BARE)


def _made(law: Any, **options: Any) -> Any:
    """Return a law compiled, with globals that are compiled."""
    made = numba.njit(error_model="numpy", **options)(relinked(law, _compiled))
    made.__class__ = CompiledLaw
    return made


@cache
def kept_in() -> Path:
    """Return the folder of what is kept on disk, by a number of the sources of all laws and of
    where they are, as Numba keeps it: what is kept of others is not used.
    """
    package = Path(vectors.__file__).resolve().parents[1]
    total = hashlib.sha256(f"{numba.__version__} {package}".encode())
    for part in LAWS:
        for file in sorted((package / part.rpartition(".")[2]).rglob("*.py")):
            total.update(file.read_bytes())
    folder = Path.home() / ".cache" / "pmwvc" / total.hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _compiled(value: Any) -> Any:
    """Return what stands for a global of a law in its compiled form."""
    if isinstance(value, Family):
        return _family(value)
    return _inside(value) if is_law(value) and value not in FORMS else value


@cache
def _family(family: Family) -> Any:
    """Return a function that is overloaded by the type of its first argument."""

    def stub(first, *others):
        raise NotImplementedError

    stub.__name__ = family.name

    def choose(first, *others):
        kind = getattr(first, "instance_class", type(None))
        if kind not in family.members and family.members.default_factory is None:
            return None
        chosen = _inside(family.members[kind])
        return lambda first, *others: chosen(first, *others)

    overload(stub, jit_options=BARE)(choose)
    return stub


class _Replace(templates.AbstractTemplate):
    """The type of ``s._replace(field=value, ...)``."""

    key = "NamedTuple._replace"

    def generic(self, args, kws):
        if args or not kws.keys() <= {*self.this.fields}:
            return None
        names = self.this.fields
        given = [kws.get(name, types.Omitted(None)) for name in names]
        kinds = [kws.get(name, kind) for name, kind in zip(names, self.this, strict=True)]
        made = types.BaseTuple.from_types(kinds, self.this.instance_class)
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        fields = [inspect.Parameter(name, kind, default=None) for name in names]
        found = templates.signature(made, *given, recvr=self.this)
        return found.replace(pysig=inspect.Signature(fields))


class _HasReplace(templates.AttributeTemplate):
    def resolve__replace(self, s):
        return types.BoundFunction(_Replace, s)


for _kind in (types.NamedTuple, types.NamedUniTuple):
    templates.infer_getattr(type(_kind.__name__, (_HasReplace,), {"key": _kind}))


@lower_builtin(_Replace.key, types.BaseTuple, types.VarArg(types.Any))
def _replace(context, builder, sig, args):
    """Build the tuple from the fields given, and those of the old one."""
    (old, *kinds), (before, *given), fields = sig.args, args, []
    for i, (kind, value) in enumerate(zip(kinds, given, strict=True)):
        if isinstance(kind, types.Omitted):
            kind, value = old[i], builder.extract_value(before, i)
        fields.append(context.cast(builder, value, kind, sig.return_type[i]))
    made = context.make_tuple(builder, sig.return_type, fields)
    return impl_ret_borrowed(context, builder, sig.return_type, made)


def _built(text: str) -> Any:
    """Return the function of a generated text."""
    found: dict[str, Any] = {}
    exec(text, found)  # texts of this module only
    return found["built"]


def _tuple(elements: list[str]) -> str:
    return f"({', '.join(elements)},)" if elements else "()"


def _each(law, rows, *shared):
    passed = "".join(f", shared[{k}]" for k in range(len(shared)))
    elements = [
        f"law({', '.join(f'rows[{k}][{i}]' for k in range(len(rows)))}{passed})"
        for i in range(len(rows[0]))
    ]
    return _built(f"def built(law, rows, *shared):\n    return {_tuple(elements)}")


def _chain(law, states, u, params):
    lines = [f"s{i}, u = law(states[{i}], u, params[{i}])" for i in range(len(states))]
    after = _tuple([f"s{i}" for i in range(len(states))])
    body = "\n    ".join([*lines, f"return {after}, u"])
    return _built(f"def built(law, states, u, params):\n    {body}")


def _columns(rows):
    of_one = range(len(rows[0]))
    elements = [_tuple([f"rows[{i}][{k}]" for i in range(len(rows))]) for k in of_one]
    return _built(f"def built(rows):\n    return {_tuple(elements)}")


def _by_axis(function):
    """Return the form of a function of two arguments, the first of which is a vector."""
    return lambda a, b: unrolled(function, len(a))


# Compiled forms of what builds tuples.
FORMS = {vectors.each: _each, vectors.chain: _chain, vectors.columns: _columns}
ELEMENTWISE = vectors.plus, vectors.minus, vectors.times, vectors.scaled
FORMS |= {law: _by_axis(law) for law in ELEMENTWISE}
for _law, _form in FORMS.items():
    overload(_law, jit_options=BARE)(_form)
