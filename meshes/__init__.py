"""What exists in space: meshes, sections and materials."""
