"""The layers of this package. They are plugins: see layers.xml."""
