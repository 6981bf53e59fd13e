"""The GMS model from pre-sliding cycles: virgin curve, knots, refinement by replay."""
