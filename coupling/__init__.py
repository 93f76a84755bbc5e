"""Case folders, the staggered coupling of heat and motion, and what becomes of the results."""
