"""The GMS model from pre-sliding loops: virgin curve, knots, refinement by replay."""
