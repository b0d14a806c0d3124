"""Scripts that measure and print the figures that the documents state."""
