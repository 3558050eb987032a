"""Labels with a journal, and the node label_manager."""
