"""Transient heat on networks of members: solvers behind one contract."""
