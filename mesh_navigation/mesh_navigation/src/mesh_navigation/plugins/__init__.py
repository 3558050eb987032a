"""What planners, controllers and recovery behaviors are, and how they are found."""
