"""The controllers of this package, described in controllers.xml, and what they are made of."""
