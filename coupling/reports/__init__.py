"""Reports of speed: what is measured, and how it is written down."""
