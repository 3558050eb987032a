"""What readers and writers of several formats are made of."""
