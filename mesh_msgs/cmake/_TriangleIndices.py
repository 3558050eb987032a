"""The name of release 1.0."""
from ._MeshTriangleIndices import MeshTriangleIndices as TriangleIndices  # noqa: F401
