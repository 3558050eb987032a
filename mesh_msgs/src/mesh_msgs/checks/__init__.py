"""The rules that received messages keep, for each kind of message."""
