"""fric: friction identification and compensation for feed drives.

All that the command line does can be done in a few lines of Python from here. The names below are loaded when
they are first used, so that ``import fric`` costs nothing.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
