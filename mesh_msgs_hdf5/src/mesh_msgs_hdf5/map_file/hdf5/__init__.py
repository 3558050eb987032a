"""HDF5 files opened, guarded and decoded: the only place that reads what a stranger made."""
