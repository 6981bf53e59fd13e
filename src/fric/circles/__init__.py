"""Circle tests that were measured: taken apart, compared with a prediction, and what a controller learns from them."""
