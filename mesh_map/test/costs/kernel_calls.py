"""Which kernels are called: shows what is computed, and what is taken from elsewhere."""

import collections
import contextlib
from unittest import mock

from mesh_map import _kernels


@contextlib.contextmanager
def counted_kernels():
    """A Counter of the kernels that are called meanwhile, by their names."""
    counts = collections.Counter()

    def counted(name, kernel):
        def call(*arguments, **keywords):
            counts[name] += 1
            return kernel(*arguments, **keywords)

        return call

    with contextlib.ExitStack() as stack:
        for name, kernel in list(vars(_kernels).items()):
            if callable(kernel) and not isinstance(kernel, type) and not name.startswith("__"):
                stack.enter_context(mock.patch.object(_kernels, name, counted(name, kernel)))
        yield counts
