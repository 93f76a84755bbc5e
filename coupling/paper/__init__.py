"""The source of the project taken at its word: Hua et al., Aerospace 2026, 13(6), 529.

``thermobody report paper`` goes through its tables, figures and claims. Each stands in a section,
a module with ``entries(work)``, beside what its printed inputs give here, what the corrected
physics gives, and a verdict in words. ``coupling.paper.sections`` lists them.
"""
