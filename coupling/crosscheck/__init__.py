"""Beams against a 3D continuum, against other programs and against formulas, stage by stage."""
