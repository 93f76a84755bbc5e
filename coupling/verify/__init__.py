"""Problems with known answers: ``thermobody verify [AREA]``."""
