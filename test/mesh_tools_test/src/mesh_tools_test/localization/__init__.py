"""What is measured of localization."""
