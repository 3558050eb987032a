"""From nowhere: poses on drivable ground, scored by a scan."""
