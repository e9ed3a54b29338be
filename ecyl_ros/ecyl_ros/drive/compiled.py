"""The compiler settings of every numeric kernel, in one place.

Fast-math stays off: results must agree to the last bit whether a function is called tick by tick
from a node or inlined in the engine's loop. The GIL is released, so that threads can run drives
side by side.

Compiled code is cached on disk. Numba looks only at the file a function stands in, not at those
of the functions it calls; the cache folder is therefore named after a digest of all files that
hold kernels, and a change in any of them, or one more effect, compiles again.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from numba import njit
from numba.core import config

_PACKAGE = Path(__file__).resolve().parents[1]
_SOURCES = (
    "drive/*.py",
    "drive/reference/swing.py",
    "drive/rigid/*.py",
    "effects/*.py",
    "gap/fit/robust.py",
    "gap/rigid/decimated.py",
    "gap/rigid/wave_sums.py",
    "gap/study/cylinder/*.py",
    "gap/study/rigid/*.py",
)  # that hold kernels


def _sources_digest() -> str:
    digest = hashlib.sha256()
    for source in _SOURCES:
        for path in sorted(_PACKAGE.glob(source)):
            digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def _cache_folder() -> str:
    """A writable folder for this version's compiled code; empty: Numba chooses."""
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ecyl_ros"
    for parent in (_PACKAGE / "__pycache__", user):
        folder = parent / f"kernels-{_sources_digest()}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return str(folder)
    return ""


def kernel(
    function: Callable, *, cache: bool = True, inline: bool = True, allocates: bool = False
) -> Callable:
    """Compile `function` when it is first called; with `cache`, keep the machine code on disk.

    inline: put it in place of its calls from other kernels. Left to itself the compiler calls most
    of them, and a tick of the drive takes half as long again.
    allocates: it makes arrays. Others do without Numba's count of references to arrays, which its
    optimiser leaves in beside any call that could raise: half of a tick.
    """
    chosen = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = chosen or _cache_folder()  # type: ignore[attr-defined]
    try:
        return njit(  # type: ignore[call-overload]
            cache=cache,
            fastmath=False,
            error_model="numpy",
            nogil=True,
            forceinline=inline,
            _nrt=allocates,
        )(function)
    finally:
        config.CACHE_DIR = chosen  # type: ignore[attr-defined]


def called(function: Callable) -> Callable:
    """A kernel that stays a call: large or seldom needed, it would only take long to compile."""
    return kernel(function, inline=False)


def allocating(function: Callable) -> Callable:
    """A called kernel that makes arrays."""
    return kernel(function, inline=False, allocates=True)


def over_arrays(compiled: Callable) -> Callable:
    """The function behind a kernel written in NumPy: the same law along a whole motion."""
    function: Callable = compiled.py_func  # type: ignore[attr-defined]
    return function
