"""Any friction model by replay along a measured motion, and models compared."""
