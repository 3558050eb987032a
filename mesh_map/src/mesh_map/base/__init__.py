"""What every room needs: errors, checks of arguments, parameters, digests, cancelling, plugins."""
