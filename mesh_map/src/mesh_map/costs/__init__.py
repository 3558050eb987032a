"""The layer stack: what a layer is, in which order layers are evaluated, and their combination."""
