"""The planners of this package, described in planners.xml."""
