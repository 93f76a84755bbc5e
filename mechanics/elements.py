"""Element families by name; each is imported, and compiled, only when a scene uses it."""

FAMILIES = {
    "beam3243": "mechanics.beam3243:build",
    "cable": "mechanics.cable:build",
}
