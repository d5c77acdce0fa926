"""The module t4d, which Blender's Python must have, and the files it has opened."""

import contextlib
import os
import sys
import warnings

from .recorder import Problem


def module():
    try:
        import t4d
    except ImportError as missing:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise Problem(
            f"Blender's Python {version} cannot load the module t4d ({missing}); install the wheel of t4d "
            f"for Python {version} by '{sys.executable} -m pip install WHEEL', or, for Debian's Blender, "
            "the Debian package of t4d, and start Blender again"
        ) from None
    return t4d


# The exceptions of the module and the system when something cannot be done.
FAILURES = (Problem, KeyError, MemoryError, NotImplementedError, OSError, RuntimeError, ValueError)


def sentence(failure):
    return str(failure.args[0]) if isinstance(failure, KeyError) else str(failure)


@contextlib.contextmanager
def remarks():
    """A list that has, after the block, what the module warned of."""
    found = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        yield found
    found += [str(one.message) for one in caught if issubclass(one.category, UserWarning)]


_opened = {}


def opened(path):
    """The 4D mesh in a file, which is opened again if it has changed."""
    try:
        found = os.stat(path)
        state = found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns
    except OSError:
        state = None  # gone, or a URL
    if path not in _opened or _opened[path][0] != state:
        _opened.pop(path, None)
        _opened[path] = state, module().read(path)
    return _opened[path][1]
