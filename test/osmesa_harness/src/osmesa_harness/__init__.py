"""Runs programs that draw with OpenGL where there is no screen: behind scripts/*."""
