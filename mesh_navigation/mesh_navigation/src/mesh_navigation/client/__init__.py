"""Goals for a server from programs: `MeshNavigator`, and what it is made of."""
