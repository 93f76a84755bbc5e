"""Flexible multibody dynamics with the absolute nodal coordinate formulation (ANCF)."""
