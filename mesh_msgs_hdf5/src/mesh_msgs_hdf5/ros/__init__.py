"""What both nodes say and hear: messages of a mesh, labels for the process that owns them."""
