"""Python in a separate process, which ends with the process that started it, however that ends."""

import os
import subprocess
import sys

_WATCHED = """
import os, signal, sys, threading, time
def end():
    os.read(0, 1)  # until the other end is closed
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(2.0)
    os._exit(1)
threading.Thread(target=end, daemon=True).start()
"""


def run_python(code: str, *words: str) -> subprocess.CompletedProcess[bytes]:
    """Run code in a separate process, which is terminated when this process ends; return its result."""
    reading, writing = os.pipe()
    try:
        return subprocess.run(
            [sys.executable, "-P", "-c", _WATCHED + code, *words], stdin=reading, capture_output=True, check=False
        )
    finally:
        os.close(reading)
        os.close(writing)
