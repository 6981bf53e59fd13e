"""The two axes of the paper, with the gains that its notes compute for them."""

from fric.control.cascade import Cascade
from fric.drive.plant import LinearPlant

X = LinearPlant(28.57, 4.526, 0.65e-3)
Y = LinearPlant(20.0, 8.916, 0.65e-3)
CASCADE_X = Cascade(126.0, 83.7, 3156.0, 500.0, 4000.0)
CASCADE_Y = Cascade(126.0, 42.4, 1600.0, 500.0, 4000.0)
