"""Files on the disk: their kinds, names that stay in a folder, saving in one step."""
