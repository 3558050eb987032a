"""Batches of queries on an OpenCL device: its choice, the program, and a mesh on it.

Nothing here imports pyopencl before a device is needed. Whatever fails costs one warning, and the
native queries give the same answers.
"""
