"""How the process keeps memory: for a command that streams, not for a program that fric is a guest in."""

import ctypes

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD = -1, -3  # malloc.h of glibc


def keep_freed_memory() -> None:
    """Let glibc's malloc keep up to 64 MiB of freed bytes a heap, instead of handing large blocks back to the kernel.

    A stream allocates and frees blocks of some hundred KiB over and over; fetching each anew from the kernel, page by
    page, takes a third of the time of an ingest. Where there is no glibc, nothing is done.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    mallopt(_M_MMAP_THRESHOLD, 32 << 20)  # the most that it takes
    mallopt(_M_TRIM_THRESHOLD, 64 << 20)
